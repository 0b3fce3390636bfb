// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/threads.h"

namespace sarblock {

enum class ColumnNeed { kOptional, kRequired };

/// Kind of the cells of a column.
enum class CellKind {
  kNumber,     ///< its unit is the end of the column's name
  kRowNumber,  ///< a number whose unit the cell `unit` of its row, or the parameter it is of, gives
  kCount,      ///< an integer of 0 or more
  kFlag,       ///< 0 or 1
  kText,
  kPass,   ///< id of a pass of the block
  kPoint,  ///< id of a point of the block
};

/// Whether cells of a kind are texts.
[[nodiscard]] constexpr bool IsText(CellKind kind) {
  return kind == CellKind::kText || kind == CellKind::kPass || kind == CellKind::kPoint;
}
[[nodiscard]] constexpr bool IsInteger(CellKind kind) {
  return kind == CellKind::kCount || kind == CellKind::kFlag;
}

struct TableColumn {
  std::string_view name;
  ColumnNeed need = ColumnNeed::kOptional;
  CellKind kind = CellKind::kNumber;
};
/// The columns of a table. Cells are asked for by the number of their column in it.
using Schema = std::span<const TableColumn>;

/// The same columns, all of texts: cells as they are in a text file.
[[nodiscard]] std::vector<TableColumn> AsTexts(Schema schema);

/// A schema that is known when the program is compiled. kPathColumns("x_m") is the number of a
/// column, kPathColumns("x_m", "y_m", "z_m") has three; a name that is not in it does not compile.
template <std::size_t N>
struct Columns {
  TableColumn columns[N];

  consteval std::size_t operator()(std::string_view name) const {
    std::size_t number = 0;
    while (columns[number].name != name) ++number;
    return number;
  }
  template <typename... Names>
  consteval auto operator()(std::string_view first, Names... names) const {
    return std::array{(*this)(first), (*this)(names)...};
  }
  [[nodiscard]] constexpr std::size_t size() const { return N; }
  [[nodiscard]] constexpr const TableColumn* begin() const { return columns; }
  [[nodiscard]] constexpr const TableColumn* end() const { return columns + N; }
};
template <std::size_t N>
Columns(const TableColumn (&)[N]) -> Columns<N>;

/// "m" for a name that ends in "_m"; "1" for one that ends in no unit.
[[nodiscard]] std::string_view UnitOfColumn(std::string_view name);

/// A table of a block, a result or a part: what readers, writers and both kinds of files go by. The
/// columns are in the order in which they are written.
struct TableDescription {
  std::string_view name;
  Schema columns;
};
/// All tables of a block, a result or a part, in the order in which they are written.
[[nodiscard]] std::span<const TableDescription> TablesOf(FolderContent content);

namespace column {
inline constexpr ColumnNeed kRequired = ColumnNeed::kRequired;
inline constexpr ColumnNeed kOptional = ColumnNeed::kOptional;
}  // namespace column

inline constexpr Columns kPathColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"time_s", column::kRequired},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"vx_mps", column::kRequired},
    {"vy_mps", column::kRequired},
    {"vz_mps", column::kRequired},
    {"adjusted",
     column::kOptional,
     CellKind::kText},  // of a result: "all", or what is not in the states
}};
/// Looks need time and range, or line and pixel.
inline constexpr Columns kLookColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"point", column::kRequired, CellKind::kPoint},
    {"time_s"},
    {"range_m"},
    {"squint_deg"},
    {"doppler_hz"},
    {"range_sigma_m"},
    {"azimuth_sigma_m"},
    {"time_sigma_s"},
    {"doppler_sigma_hz"},
    {"rejected", column::kOptional, CellKind::kFlag},
    {"line"},
    {"pixel"},
    {"line_sigma_px"},
    {"pixel_sigma_px"},
    {"range_delay_m"},
    {"time_shift_s"},
}};
inline constexpr Columns kPointColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"role", column::kOptional, CellKind::kText},
    {"x_m"},
    {"y_m"},
    {"z_m"},
    {"lat_deg"},
    {"lon_deg"},
    {"h_m"},
    {"sigma_e_m"},
    {"sigma_n_m"},
    {"sigma_u_m"},
    {"cov_en_m2"},
    {"cov_eu_m2"},
    {"cov_nu_m2"},
    {"frame", column::kOptional, CellKind::kText},
    {"epoch"},
    {"vx_mpy"},
    {"vy_mpy"},
    {"vz_mpy"},
    {"geoid", column::kOptional, CellKind::kText},
}};
inline constexpr Columns kTruthColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
}};

inline constexpr Columns kResultPointColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"role", column::kRequired, CellKind::kText},
    {"status", column::kRequired, CellKind::kText},
    {"looks", column::kRequired, CellKind::kCount},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"lat_deg"},
    {"lon_deg"},
    {"h_m"},
    {"sigma_e_m", column::kRequired},
    {"sigma_n_m", column::kRequired},
    {"sigma_u_m", column::kRequired},
    {"cov_en_m2", column::kRequired},
    {"cov_eu_m2", column::kRequired},
    {"cov_nu_m2", column::kRequired},
    {"intersection_deg"},
    {"sigma_leberl_across_m"},
    {"sigma_leberl_up_m"},
    {"sigma_leberl_path_across_m"},
    {"sigma_leberl_path_up_m"},
    {"leberl_across_azimuth_deg"},
    {"redundancy"},
    {"error_e_m"},
    {"error_n_m"},
    {"error_u_m"},
    {"chi_square_3"},
    {"error_sigma_e_m"},
    {"error_sigma_n_m"},
    {"error_sigma_u_m"},
    {"sigma_held_e_m"},
    {"sigma_held_n_m"},
    {"sigma_held_u_m"},
    {"cov_held_en_m2"},
    {"reason", column::kOptional, CellKind::kText},
}};
inline constexpr Columns kParameterColumns{{
    {"pass", column::kRequired, CellKind::kText},  // or the name of a shared group
    {"parameter", column::kRequired, CellKind::kText},
    {"unit", column::kRequired, CellKind::kText},
    {"value", column::kRequired, CellKind::kRowNumber},
    {"sigma", column::kRequired, CellKind::kRowNumber},
    {"prior_sigma", column::kRequired, CellKind::kRowNumber},
    {"significance"},
    {"kept", column::kOptional, CellKind::kText},
    {"prior_redundancy"},
    {"prior_w"},
}};
inline constexpr Columns kParameterCovarianceColumns{{
    {"pass_a", column::kRequired, CellKind::kText},
    {"parameter_a", column::kRequired, CellKind::kText},
    {"pass_b", column::kRequired, CellKind::kText},
    {"parameter_b", column::kRequired, CellKind::kText},
    {"covariance", column::kRequired, CellKind::kRowNumber},
}};
inline constexpr Columns kSelectionColumns{{
    {"candidate", column::kRequired, CellKind::kText},
    {"passes", column::kOptional, CellKind::kText},
    {"parameters", column::kOptional, CellKind::kCount},
    {"test", column::kOptional, CellKind::kText},
    {"statistic"},
    {"f"},
    {"p"},
    {"delta_bic"},
    {"condition"},
    {"posterior_prior"},
    {"verdict", column::kRequired, CellKind::kText},
    {"reason", column::kOptional, CellKind::kText},
    {"step", column::kOptional, CellKind::kCount},
}};
inline constexpr Columns kSimplificationColumns{{
    {"simplification", column::kRequired, CellKind::kText},
    {"bound_m"},
    {"sigma_m"},
    {"fraction"},
    {"allowed", column::kOptional, CellKind::kFlag},
    {"taken", column::kOptional, CellKind::kFlag},
    {"verdict", column::kOptional, CellKind::kText},
}};
inline constexpr Columns kStripColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"look", column::kOptional, CellKind::kText},
    {"time_s", column::kRequired},
    {"strip_time", column::kRequired},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"near_x_m"},
    {"near_y_m"},
    {"near_z_m"},
    {"far_x_m"},
    {"far_y_m"},
    {"far_z_m"},
    {"correction_along_m"},
    {"correction_across_m"},
    {"correction_up_m"},
    {"sigma_along_m"},
    {"sigma_across_m"},
    {"sigma_up_m"},
}};
/// The last four are written where a pass has an image.
inline constexpr Columns kResidualColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"point", column::kRequired, CellKind::kPoint},
    {"range_residual_m", column::kRequired},
    {"azimuth_residual_m", column::kRequired},
    {"range_redundancy"},
    {"azimuth_redundancy"},
    {"range_w"},
    {"azimuth_w"},
    {"range_tau"},
    {"azimuth_tau"},
    {"range_mdb_m"},
    {"azimuth_mdb_m"},
    {"range_influence_m"},
    {"azimuth_influence_m"},
    {"weight"},
    {"rejected", column::kRequired, CellKind::kFlag},
    {"reason", column::kOptional, CellKind::kText},
    {"finding", column::kOptional, CellKind::kCount},
    {"line"},
    {"pixel"},
    {"line_residual_px"},
    {"pixel_residual_px"},
    {"reduction_range_m"},
    {"reduction_time_s"},
}};
inline constexpr Columns kControlColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"component", column::kRequired, CellKind::kText},
    {"residual_m", column::kRequired},
    {"sigma_m"},
    {"redundancy"},
    {"w"},
    {"tau"},
    {"mdb_m"},
    {"influence_m"},
}};
inline constexpr Columns kPairColumns{{
    {"point_a", column::kRequired, CellKind::kPoint},
    {"point_b", column::kRequired, CellKind::kPoint},
    {"de_m", column::kRequired},
    {"dn_m", column::kRequired},
    {"du_m", column::kRequired},
    {"cov_ee_m2", column::kRequired},
    {"cov_nn_m2", column::kRequired},
    {"cov_uu_m2", column::kRequired},
    {"cov_en_m2", column::kRequired},
    {"cov_eu_m2", column::kRequired},
    {"cov_nu_m2", column::kRequired},
    {"sigma_leberl_across_m"},
    {"sigma_leberl_up_m"},
    {"sigma_leberl_path_across_m"},
    {"sigma_leberl_path_up_m"},
}};
inline constexpr std::array kPairCovariance =
    kPairColumns("cov_ee_m2", "cov_nn_m2", "cov_uu_m2", "cov_en_m2", "cov_eu_m2", "cov_nu_m2");
inline constexpr Columns kMonteCarloColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"sample_sigma_e_m"},
    {"sample_sigma_n_m"},
    {"sample_sigma_u_m"},
    {"sigma_e_m"},
    {"sigma_n_m"},
    {"sigma_u_m"},
    {"ratio_e"},
    {"ratio_n"},
    {"ratio_u"},
    {"normalised_square"},
    {"coverage_50"},
    {"coverage_90"},
    {"coverage_99"},
}};
/// Returns what `work` returns. An InputError of `work` that names no file, because the code that
/// throws knows none, gets the file or folder `input`.
template <typename Work>
auto Naming(const std::string& input, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    if (!error.place().file.empty()) throw;
    throw InputError(FilePlace{input, 0, error.place().field}, error.problem());
  }
}

/// Rows of a table that a thread makes at a time, and the rows of a chunk of an HDF5 file: 64 KiB
/// of numbers.
inline constexpr std::size_t kRowsAtOnce = 8192;

/// Calls make() on all threads for pieces of [0, count), `per_piece` items each, and take() for one
/// piece at a time, in order, while later ones are being made. At most ItemsAtOnce() pieces are in
/// memory, and their storage is reused. What is taken does not depend on the number of threads. The
/// first error ends both.
template <typename Piece>
void MakeInOrder(std::size_t count,
                 std::size_t per_piece,
                 const std::function<void(std::size_t, std::size_t, Piece*)>& make,
                 const std::function<void(Piece*)>& take) {
  struct Kept {
    std::size_t begin = 0;
    Piece piece;
  };
  std::vector<Kept> kept(ItemsAtOnce());
  std::size_t begun = 0;
  const auto next = [&](std::size_t place) {
    if (begun >= count) return false;
    kept[place].begin = begun;
    begun += std::min(per_piece, count - begun);
    return true;
  };
  const auto work = [&](std::size_t place) {
    const std::size_t begin = kept[place].begin;
    make(begin, begin + std::min(per_piece, count - begin), &kept[place].piece);
  };
  PipeInOrder(kept.size(), next, work, [&](std::size_t place) { take(&kept[place].piece); });
}

class TableReader;

/// The cells of a column in some rows: numbers or texts.
struct Column {
  /// NaN where none is given; ends with the last row that gives one.
  std::vector<double> numbers;
  /// Texts: row i has (*texts)[indices[i]].
  std::vector<std::uint32_t> indices;
  const IdTable* texts = nullptr;  ///< null: numbers; `own`, or texts that outlive the rows
  IdTable own;                     ///< distinct texts of these rows in their order

  [[nodiscard]] double Number(std::size_t row) const {
    return row < numbers.size() ? numbers[row] : std::numeric_limits<double>::quiet_NaN();
  }
  void SetNumber(std::size_t row, double value) {
    numbers.resize(row, std::numeric_limits<double>::quiet_NaN());
    numbers.push_back(value);
  }
  /// Appends a text of `own` for the next row.
  void AppendText(std::string_view text);
  /// Infinity is an error of `file`; every NaN becomes the one of std::numeric_limits.
  void SettleNumbers(std::string_view file);
};

/// Some rows of a table as columns: what all kinds of files are read to and written from.
struct Batch {
  Batch() = default;
  Batch(const Batch&) = delete;  // columns point to texts of their own
  Batch& operator=(const Batch&) = delete;

  /// Begins with no rows and columns without cells, one for each of the schema.
  void Begin(Schema schema);
  /// Completes the columns of rows that were written: texts that no row gave are empty.
  void End();

  std::size_t rows = 0;
  std::size_t first = 0;            ///< lines or rows of the table before these
  std::vector<Column> columns;      ///< by column of the schema
  std::string text;                 ///< of a text file: these lines
  std::vector<std::uint32_t> line;  ///< of a text file: line of each row, counted from `first`
  std::exception_ptr error;         ///< what is wrong with the row behind the last
  const TableReader* table = nullptr;
};

/// A row that is read. What a cell may hold is checked here and by the caller, once for all kinds
/// of files; columns are numbers of the schema. What is wrong throws InputError with its place.
class Row {
 public:
  Row(const Batch& batch, std::size_t row) : batch_(batch), row_(row) {}

  /// True if the cell is there and not empty.
  [[nodiscard]] bool Given(std::size_t column) const;
  /// The cell of a column of texts; empty where it is not given.
  [[nodiscard]] std::string_view Text(std::size_t column) const {
    const Column& cells = batch_.columns[column];
    return cells.texts == nullptr ? std::string_view() : (*cells.texts)[cells.indices[row_]];
  }
  /// The same, refused if it is empty or holds control characters: a name of a pass or a point.
  [[nodiscard]] std::string_view Id(std::size_t column) const;
  /// A finite number, or NaN (kNotGiven) for an empty cell.
  [[nodiscard]] double Number(std::size_t column) const {
    const double value = batch_.columns[column].Number(row_);
    if (std::isnan(value)) RefuseUnreadable(column, value);
    return value;
  }
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> Numbers(const std::array<std::size_t, N>& columns) const {
    std::array<double, N> numbers;
    for (std::size_t k = 0; k < N; ++k) numbers[k] = Number(columns[k]);
    return numbers;
  }
  /// A finite number; an empty cell is refused.
  [[nodiscard]] double RequiredNumber(std::size_t column) const;
  /// A number above 0, or NaN for an empty cell.
  [[nodiscard]] double PositiveNumber(std::size_t column) const;
  /// An integer of 0 to 2^32 - 1; 0 for an empty cell.
  [[nodiscard]] std::uint32_t Count(std::size_t column) const;
  /// True for 1, false for 0 or an empty cell.
  [[nodiscard]] bool Flag(std::size_t column) const;

  [[nodiscard]] const Batch& batch() const { return batch_; }
  [[nodiscard]] std::size_t number() const { return row_; }  ///< within the batch
  /// Line (row) of the table, from 1.
  [[nodiscard]] std::size_t line() const {
    return batch_.first + (batch_.line.empty() ? row_ + 1 : batch_.line[row_]);
  }
  [[nodiscard]] FilePlace Place(std::size_t column) const;
  [[noreturn]] void Fail(std::size_t column, const std::string& problem) const;

  /// A special NaN for a cell that is not a valid number; Number() then throws and says what is
  /// wrong.
  [[nodiscard]] static double Unreadable();

 private:
  void RefuseUnreadable(std::size_t column, double value) const;
  const Batch& batch_;
  std::size_t row_;
};

/// The number that a cell of text holds, NaN where it is empty, or Row::Unreadable().
[[nodiscard]] double NumberOfText(std::string_view cell, CellKind kind);

/// Why a text cannot be a name of a pass or a point; null: it can.
[[nodiscard]] const char* ProblemOfId(std::string_view id);

/// Reads a table, some rows at a time, whatever it is stored in.
class TableReader {
 public:
  virtual ~TableReader() = default;

  /// Takes the next rows out of the file; false at the end. By one thread at a time.
  [[nodiscard]] virtual bool Next(Batch* batch) = 0;
  /// Makes columns of what Next() took. Several threads may do so, each with a batch of its own.
  virtual void Parse(Batch* batch) const = 0;
  /// Rows to come where that is known; else 0.
  [[nodiscard]] virtual std::size_t RowsLeft() const { return 0; }
  /// A cell as a message shows it.
  [[nodiscard]] virtual std::string TextOfCell(const Row& row, std::size_t column) const = 0;
  /// The place of a cell; line (row) 0 is the head of the column.
  [[nodiscard]] virtual FilePlace PlaceAt(std::size_t line, std::size_t column) const = 0;
  /// "line 12", for messages.
  [[nodiscard]] virtual std::string NameOfLine(std::size_t line) const = 0;

  /// Possible mistakes in the lines of the table, although all of them could be read: sentences for
  /// people.
  [[nodiscard]] virtual std::vector<std::string> doubts() const { return {}; }
  /// The first of the lines that begin with # and have as many cells as the header; 0: there is
  /// none, or the table is not one of lines.
  [[nodiscard]] virtual std::size_t first_commented_row() const { return 0; }
  /// The file, for messages.
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Columns of the file that nobody asked for.
  [[nodiscard]] const std::vector<std::string>& unknown_columns() const { return unknown_; }
  /// True if the file has this column.
  [[nodiscard]] bool Has(std::size_t column) const { return place_[column] != kAbsent; }
  /// Throws if it does not.
  void RequireColumn(std::size_t column) const;

 protected:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

  TableReader(std::string file, Schema schema);
  void RequireColumns() const;
  /// What the table has in place of a missing column: "the header has a,b".
  [[nodiscard]] virtual std::string ColumnsThere() const = 0;

  std::string file_;
  std::vector<TableColumn> schema_;
  std::vector<std::string> names_;  // of the columns of the schema
  std::vector<std::size_t> place_;  // by column: where it is in the file
  std::vector<std::string> unknown_;
};

/// Adds one warning about unknown columns.
void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings);
/// Adds the warnings about lines of the table, once all were read.
void WarnOfDoubts(const TableReader& reader, std::vector<std::string>* warnings);

/// Reads all rows: `work` makes something of the rows of each batch, on all threads; `take` gets
/// both, one batch at a time, in their order. What is taken does not depend on the number of
/// threads. An error is that of the first row with one; `work` puts its own to Batch::error, with
/// the rows before it made.
template <typename Made>
void ForBatches(TableReader* reader,
                const std::function<void(Batch*, Made*)>& work,
                const std::function<void(Batch*, Made*)>& take) {
  struct Kept {
    Batch batch;
    Made made;
  };
  std::vector<Kept> kept(ItemsAtOnce());
  const auto read = [&](std::size_t place) {
    reader->Parse(&kept[place].batch);
    work(&kept[place].batch, &kept[place].made);
  };
  const auto take_in_order = [&](std::size_t place) {
    take(&kept[place].batch, &kept[place].made);
    if (kept[place].batch.error) std::rethrow_exception(kept[place].batch.error);
  };
  PipeInOrder(
      kept.size(),
      [&](std::size_t place) { return reader->Next(&kept[place].batch); },
      read,
      take_in_order);
}

/// Calls take(row) for all rows in their order.
void ForRows(TableReader* reader, const std::function<void(const Row&)>& take);

/// Numbers that a caller finds for the texts of a column, in batches in their order. Each distinct
/// text is looked up once: per file where this stores each text once, else per batch.
class FoundTexts {
 public:
  /// What `find` returned for the text of this cell. It may throw; kUnknown is not kept.
  template <typename Find>
  [[nodiscard]] std::uint32_t Of(const Row& row, std::size_t column, const Find& find) {
    const Column& cells = row.batch().columns[column];
    if (cells.texts == nullptr) return find();
    const bool of_batch = cells.texts == &cells.own;
    if (cells.texts != texts_ || (of_batch && row.batch().first != first_)) {
      texts_ = cells.texts;
      first_ = row.batch().first;
      found_.assign(texts_->size(), kUnknown);
    }
    std::uint32_t& found = found_[cells.indices[row.number()]];
    if (found == kUnknown) found = find();
    return found;
  }
  static constexpr std::uint32_t kUnknown = 0xffffffffu;

 private:
  const IdTable* texts_ = nullptr;
  std::size_t first_ = 0;
  std::vector<std::uint32_t> found_;
};

/// A row that is written, behind the others of its batch: cells by column of the schema, in any
/// order; those that are not set are empty.
class NewRow {
 public:
  explicit NewRow(Batch* batch) : batch_(*batch), row_(batch->rows++) {}

  /// NaN is an empty cell. Infinity is refused when the rows are written: no table holds one.
  NewRow& Number(std::size_t column, double value) {
    if (!std::isnan(value)) batch_.columns[column].SetNumber(row_, value);
    return *this;
  }
  /// The elements of an array or a vector.
  template <std::size_t N, typename Values>
  NewRow& Numbers(const std::array<std::size_t, N>& columns, const Values& values) {
    for (std::size_t k = 0; k < N; ++k) Number(columns[k], values.data()[k]);
    return *this;
  }
  /// A count or a flag.
  template <std::integral T>
  NewRow& Integer(std::size_t column, T value) {
    return Number(column, static_cast<double>(value));
  }
  NewRow& Text(std::size_t column, std::string_view text);
  /// The id of a pass or a point: number `index` of `ids`, which is the same for all rows.
  NewRow& Id(std::size_t column, const IdTable& ids, std::uint32_t index);

 private:
  Batch& batch_;
  std::size_t row_;
};

/// Writes a table, some rows at a time, whatever it is stored in; it appears whole at Commit().
class TableWriter {
 public:
  virtual ~TableWriter() = default;

  /// Gets rows ready to be written. Several threads may do so, each with a batch of its own. Throws
  /// InputError for what no table holds.
  virtual void Format(Batch* batch) const = 0;
  /// Writes them behind those before. By one thread at a time.
  virtual void Write(Batch* batch) = 0;
  virtual void Commit() = 0;
  /// The columns of its batches; not all of them need be written.
  [[nodiscard]] Schema schema() const { return schema_; }

 protected:
  TableWriter(Schema schema, std::span<const std::string_view> left_out);

  std::vector<TableColumn> schema_;
  std::vector<std::size_t> written_;  // columns of the schema in their order
};

/// Calls `write(begin, end, batch)` on all threads for pieces of [0, count) of `per_piece` items,
/// which adds their rows to a batch; batches are written in their order.
void WriteRows(std::size_t count,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, Batch*)>& write,
               std::size_t per_piece = kRowsAtOnce);
/// The same with write(item, batch) for each item.
template <typename Write>
void WriteEach(std::size_t count, TableWriter* out, const Write& write) {
  WriteRows(count, out, [&write](std::size_t begin, std::size_t end, Batch* batch) {
    for (std::size_t i = begin; i < end; ++i) write(i, batch);
  });
}

/// Lists of all ids of a block, where they are known: a file that stores each id once has them in
/// this order. Null where they are not: it has those of its tables then.
struct BlockIds {
  const IdTable* passes = nullptr;
  const IdTable* points = nullptr;
};

/// Where the tables of a block or a result come from: a folder, one file of all, texts or arrays in
/// memory.
class TableSource {
 public:
  explicit TableSource(FolderContent content) : content_(content) {}
  virtual ~TableSource() = default;
  /// Name for messages and text of a file that must be there.
  [[nodiscard]] virtual std::pair<std::string, std::string> Read(std::string_view file) const = 0;
  /// A table by its name without ending ("points"), or nothing if it is not there.
  [[nodiscard]] virtual std::unique_ptr<TableReader> Open(std::string_view table,
                                                          Schema schema) const = 0;
  /// The name for messages of a table that must be there.
  [[nodiscard]] virtual std::string NameOf(std::string_view table) const = 0;
  /// Default name of a block or result that gives itself none.
  [[nodiscard]] virtual std::string DefaultName() const = 0;
  [[nodiscard]] virtual BlockIds Ids() const { return {}; }
  /// A table that must be there.
  [[nodiscard]] std::unique_ptr<TableReader> Require(std::string_view table, Schema schema) const;
  [[nodiscard]] FolderContent content() const { return content_; }

 protected:
  [[noreturn]] void FailMissing(const std::string& file, const char* what) const;
  FolderContent content_;
};

/// Where the tables of a block or a result are written: a folder or one file of all.
class TableSink {
 public:
  virtual ~TableSink() = default;
  /// A table with the columns of the schema but for those that are named; one is open at a time.
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Open(
      std::string_view table, Schema schema, std::span<const std::string_view> left_out = {}) = 0;
  /// block.toml or summary.json, after the tables.
  virtual void WriteText(std::string_view file, std::string_view text) = 0;
  /// Where files go that are no tables; nothing where there is no folder.
  [[nodiscard]] virtual std::optional<std::filesystem::path> folder() const = 0;
};

}  // namespace sarblock
