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

/// What the cells of a column hold.
enum class CellKind {
  kNumber,     ///< its unit is the end of the column's name
  kRowNumber,  ///< a number whose unit the cell `unit` of its row, or the parameter it is of, gives
  kCount,      ///< an integer of 0 or more
  kFlag,       ///< 0 or 1
  kText,
  kPass,   ///< id of a pass of the block
  kPoint,  ///< id of a point of the block
};

/// A column of a table. Its index in the list that a reader is given is what the cell functions
/// take.
struct TableColumn {
  std::string_view name;
  ColumnNeed need = ColumnNeed::kOptional;
  CellKind kind = CellKind::kNumber;
};

/// "m" for a name that ends in "_m"; "1" for one that ends in no unit.
[[nodiscard]] std::string_view UnitOfColumn(std::string_view name);

/// A table of a block, a result or a part: what readers, writers and both kinds of files go by. The
/// columns stand in the order in which they are written.
struct TableDescription {
  std::string_view name;
  std::span<const TableColumn> columns;
};
/// All tables of a block, a result or a part, in the order in which they are written.
[[nodiscard]] std::span<const TableDescription> TablesOf(FolderContent content);

namespace column {
inline constexpr ColumnNeed kRequired = ColumnNeed::kRequired;
inline constexpr ColumnNeed kOptional = ColumnNeed::kOptional;
}  // namespace column

inline constexpr std::array<TableColumn, 8> kPathColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"time_s", column::kRequired},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"vx_mps", column::kRequired},
    {"vy_mps", column::kRequired},
    {"vz_mps", column::kRequired},
}};
/// Needed of the looks are time and range, or line and pixel.
inline constexpr std::array<TableColumn, 15> kObservationColumns{{
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
}};
inline constexpr std::array<TableColumn, 14> kPointColumns{{
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
}};
inline constexpr std::array<TableColumn, 4> kTruthColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
}};

inline constexpr std::array<TableColumn, 35> kResultPointColumns{{
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
inline constexpr std::array<TableColumn, 10> kParameterColumns{{
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
inline constexpr std::array<TableColumn, 5> kParameterCovarianceColumns{{
    {"pass_a", column::kRequired, CellKind::kText},
    {"parameter_a", column::kRequired, CellKind::kText},
    {"pass_b", column::kRequired, CellKind::kText},
    {"parameter_b", column::kRequired, CellKind::kText},
    {"covariance", column::kRequired, CellKind::kRowNumber},
}};
inline constexpr std::array<TableColumn, 13> kSelectionColumns{{
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
inline constexpr std::array<TableColumn, 7> kSimplificationColumns{{
    {"simplification", column::kRequired, CellKind::kText},
    {"bound_m"},
    {"sigma_m"},
    {"fraction"},
    {"allowed", column::kOptional, CellKind::kFlag},
    {"taken", column::kOptional, CellKind::kFlag},
    {"verdict", column::kOptional, CellKind::kText},
}};
inline constexpr std::array<TableColumn, 19> kStripColumns{{
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
/// The last four stand there where a pass has an image.
inline constexpr std::size_t kImageResidualColumns = 4;
inline constexpr std::array<TableColumn, 22> kResidualColumns{{
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
}};
inline constexpr std::array<TableColumn, 9> kControlColumns{{
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
inline constexpr std::array<TableColumn, 15> kPairColumns{{
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
inline constexpr std::array<TableColumn, 14> kMonteCarloColumns{{
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
inline constexpr std::array<TableColumn, 9> kDrawColumns{{
    {"run", column::kRequired, CellKind::kCount},
    {"converged", column::kRequired, CellKind::kFlag},
    {"variance_ratio_e", column::kRequired},
    {"variance_ratio_n", column::kRequired},
    {"variance_ratio_u", column::kRequired},
    {"normalised_square", column::kRequired},
    {"coverage_50", column::kRequired},
    {"coverage_90", column::kRequired},
    {"coverage_99", column::kRequired},
}};
inline constexpr std::array<TableColumn, 11> kSumColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"sum_ee", column::kRequired, CellKind::kText},  // integers of more digits than a double has
    {"sum_nn", column::kRequired, CellKind::kText},
    {"sum_uu", column::kRequired, CellKind::kText},
    {"sum_en", column::kRequired, CellKind::kText},
    {"sum_eu", column::kRequired, CellKind::kText},
    {"sum_nu", column::kRequired, CellKind::kText},
    {"sum_square", column::kRequired, CellKind::kText},
    {"inside_50", column::kRequired, CellKind::kCount},
    {"inside_90", column::kRequired, CellKind::kCount},
    {"inside_99", column::kRequired, CellKind::kCount},
}};

/// What `work` returns; an InputError of it that does not begin with the file or folder `input`,
/// because what throws knows no files, names it.
template <typename Work>
auto Naming(const std::string& input, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    if (std::string_view(error.what()).starts_with(input)) throw;
    throw InputError(FilePlace{input, 0, ""}, error.what());
  }
}

/// Texts in their order, wherever they stand.
class TextList {
 public:
  virtual ~TextList() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  virtual void ForEach(const std::function<void(std::string_view)>& take) const = 0;
};

/// Those of a table, which must outlive this.
class TextsOfTable final : public TextList {
 public:
  explicit TextsOfTable(const IdTable& table) : table_(table) {}
  [[nodiscard]] std::size_t size() const override { return table_.size(); }
  void ForEach(const std::function<void(std::string_view)>& take) const override {
    for (std::size_t i = 0; i < table_.size(); ++i) take(table_[i]);
  }

 private:
  const IdTable& table_;
};

/// Ids that tables hold the index of, where they stand once; null where they do not.
struct BlockIds {
  const TextList* passes = nullptr;
  const TextList* points = nullptr;
};

/// Values of a column of some rows, without the zeros that a std::vector writes first.
template <typename T>
class ColumnBuffer {
 public:
  /// Room for `rows`; the first `kept` of those before stay.
  void MakeRoom(std::size_t rows, std::size_t kept) {
    if (rows <= room_) return;
    auto values = std::make_unique_for_overwrite<T[]>(rows);
    std::copy_n(values_.get(), kept, values.get());
    values_ = std::move(values);
    room_ = rows;
  }
  [[nodiscard]] T* data() const { return values_.get(); }
  /// The first `rows`, for which there is room.
  [[nodiscard]] std::span<T> first(std::size_t rows) const { return {values_.get(), rows}; }

 private:
  std::unique_ptr<T[]> values_;
  std::size_t room_ = 0;
};

/// Rows of a table, or what is as long, that a thread makes at a time: some hundred kilobytes.
inline constexpr std::size_t kRowsPerPiece = 2048;

/// Has all threads make the pieces of [0, count), `per_piece` each, and one at a time take them, in
/// their order: while some are made, those made before are taken. ItemsAtOnce() pieces are held at
/// most. What is taken does not depend on the number of threads. The first error ends both.
template <typename Piece>
void MakeInOrder(std::size_t count,
                 std::size_t per_piece,
                 const std::function<Piece(std::size_t, std::size_t)>& make,
                 const std::function<void(Piece*)>& take) {
  struct Held {
    std::size_t begin = 0;
    Piece piece;
  };
  std::vector<Held> held(ItemsAtOnce());
  std::size_t begun = 0;
  const auto next = [&](std::size_t place) {
    if (begun >= count) return false;
    held[place].begin = begun;
    begun += std::min(per_piece, count - begun);
    return true;
  };
  const auto work = [&](std::size_t place) {
    const std::size_t begin = held[place].begin;
    held[place].piece = make(begin, begin + std::min(per_piece, count - begin));
  };
  PipeInOrder(held.size(), next, work, [&](std::size_t place) {
    take(&held[place].piece);
    held[place].piece = Piece();
  });
}

/// Reads a table row by row, whatever it is stored in: what a block or a result may hold is checked
/// here and by who asks for the cells, once for all kinds of files. Views of cells are valid until
/// the next call of Next(). Everything that is wrong throws InputError with its place.
class TableReader {
 public:
  virtual ~TableReader() = default;

  /// Goes to the next row; false at the end of the table.
  [[nodiscard]] virtual bool Next() = 0;
  /// A reader of the next rows, some at a time, that another thread may use beside this one, which
  /// goes on behind them. Null at the end. No row may be read by Next() of this one before. A part
  /// has no parts.
  [[nodiscard]] virtual std::unique_ptr<TableReader> Part() = 0;
  /// Number of rows to come where it is known before the end; else 0.
  [[nodiscard]] virtual std::size_t RowCount() const { return 0; }
  /// Line (row) of the current row, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// The file, for messages.
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Columns of the file that nobody asked for, as they stand there.
  [[nodiscard]] const std::vector<std::string>& unknown_columns() const { return unknown_; }

  /// True if the file has this column.
  [[nodiscard]] bool Has(std::size_t column) const { return place_[column] != kAbsent; }
  /// Throws if it does not.
  void RequireColumn(std::size_t column) const;
  /// True if the cell is there and not empty.
  [[nodiscard]] bool Given(std::size_t column) const {
    if (!Has(column)) return false;
    return numbers_[column] != nullptr ? !std::isnan(numbers_[column][at_])
                                       : !TextOf(column).empty();
  }
  /// The cell; empty where the column or the cell is not given.
  [[nodiscard]] std::string_view Text(std::size_t column) const {
    return Has(column) ? TextOf(column) : std::string_view();
  }
  /// The cell, refused if it is empty or holds control characters: a name of a pass or a point.
  [[nodiscard]] std::string_view Id(std::size_t column) const;
  /// What keeps a text from being a name of a pass or a point; null: nothing.
  [[nodiscard]] static const char* ProblemOfId(std::string_view id);
  /// Number of the cell's text where the file stores each text once, else kUnknown.
  [[nodiscard]] virtual std::uint32_t IndexOfText(std::size_t /*column*/) const { return kUnknown; }
  /// A finite number, or NaN (kNotGiven) for an empty cell.
  [[nodiscard]] double Number(std::size_t column) const {
    if (!Has(column)) return std::numeric_limits<double>::quiet_NaN();
    return numbers_[column] != nullptr ? numbers_[column][at_] : ParsedNumber(column);
  }
  /// A finite number; an empty cell is refused.
  [[nodiscard]] double RequiredNumber(std::size_t column) const;
  /// An integer of 0 to 2^32 - 1; 0 for an empty cell.
  [[nodiscard]] std::uint32_t Count(std::size_t column) const;
  /// True for 1, false for 0 or an empty cell.
  [[nodiscard]] bool Flag(std::size_t column) const;
  /// What `find` returns for the cell's text, an index of something. Where a file stores each text
  /// once, `find` is asked once for each: in one way for a column, and for all columns of ids of
  /// passes, or of points, of all tables of a source.
  template <typename Find>
  [[nodiscard]] std::uint32_t Lookup(std::size_t column, const Find& find) const {
    std::uint32_t* const memo = Memo(column);
    if (memo == nullptr) return find();
    if (*memo == kUnknown) *memo = find();
    return *memo;
  }

  /// Of a part that no row has been read of: Lookup() of all its rows at once, after which several
  /// threads may call Lookup() of their parts. `find` returns kUnknown for a text that Lookup() is
  /// to ask for again, which then has to throw. False where the file does not store each text once,
  /// and nothing is done.
  template <typename Find>
  [[nodiscard]] bool LookupAhead(std::size_t column, const Find& find) const {
    const NumberedTexts numbered = TextsAhead(column);
    std::uint32_t* const memos = MemosAhead(column);
    for (const std::uint32_t text : numbered.rows) {
      if (text >= numbered.count) continue;  // refused where its row is read
      std::uint32_t& memo = memos[text];
      if (memo != kUnknown) continue;
      const std::uint32_t found = find(TextOfNumbered(column, text));
      if (found != kUnknown) memo = found;  // else other threads may read it
    }
    return memos != nullptr;
  }
  /// Of such a part, what LookupAhead() found, one index a row. False where some row has none or is
  /// not allowed.
  [[nodiscard]] bool IndicesAhead(std::size_t column, std::vector<std::uint32_t>* indices) const;
  /// Of a part that no row has been read of: the numbers of all its rows, NaN where none is given,
  /// infinite where Next() refuses the row. None where the cells are text or the column is absent.
  [[nodiscard]] std::span<const double> NumbersAhead(std::size_t column) const {
    return Has(column) ? CellsAhead(column) : std::span<const double>();
  }
  /// Of such a part: whether it is known without a look at the rows that none gives this number.
  [[nodiscard]] bool NoneAhead(std::size_t column) const {
    return !Has(column) || IsUnstored(column);
  }
  /// Of such a part, where the file stores each text once: by row, the number of the cell's text.
  /// None where the cells are stored otherwise or a number has no text.
  [[nodiscard]] std::span<const std::uint32_t> TextNumbersAhead(std::size_t column) const;
  /// The text of one of these numbers.
  [[nodiscard]] std::string_view TextAhead(std::size_t column, std::uint32_t number) const {
    return TextOfNumbered(column, number);
  }
  static constexpr std::uint32_t kUnknown = 0xffffffffu;

  /// Where the cell of the current row, or of that line (row), stands.
  [[nodiscard]] FilePlace Place(std::size_t column) const { return PlaceAt(line_, column); }
  [[nodiscard]] virtual FilePlace PlaceAt(std::size_t line, std::size_t column) const = 0;
  /// "line 12", for messages.
  [[nodiscard]] virtual std::string NameOfLine(std::size_t line) const = 0;
  /// Throws InputError at the current row and this column.
  [[noreturn]] void Fail(std::size_t column, const std::string& problem) const;

 protected:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

  TableReader(std::string file, std::span<const TableColumn> columns);
  TableReader(const TableReader&) = default;  // of the same columns, for a part
  TableReader(TableReader&&) noexcept = default;
  TableReader& operator=(TableReader&&) noexcept = default;
  /// Of a column that is there.
  [[nodiscard]] virtual std::string_view TextOf(std::size_t column) const = 0;
  /// A stored number as a text, empty for NaN; `text` is where it stands if need be.
  [[nodiscard]] static std::string_view TextOfNumber(double value, std::string* text);
  /// The cell's text as a number, NaN if it is empty.
  [[nodiscard]] double ParsedNumber(std::size_t column) const;
  /// Throws where a required column has no place.
  void RequireColumns(std::span<const TableColumn> columns) const;
  /// Where Lookup() keeps what it found for the text of this cell, kUnknown before; null where
  /// texts are not numbered.
  [[nodiscard]] virtual std::uint32_t* Memo(std::size_t /*column*/) const { return nullptr; }
  /// Texts by number, those that rows to come hold.
  struct NumberedTexts {
    std::span<const std::uint32_t> rows;
    std::size_t count = 0;
  };
  /// None where texts are not numbered.
  [[nodiscard]] virtual NumberedTexts TextsAhead(std::size_t /*column*/) const { return {}; }
  /// What Memo() of each text points to, by number; null where texts are not numbered.
  [[nodiscard]] virtual std::uint32_t* MemosAhead(std::size_t /*column*/) const { return nullptr; }
  /// A text by its number.
  [[nodiscard]] virtual std::string_view TextOfNumbered(std::size_t /*column*/,
                                                        std::uint32_t /*text*/) const {
    return {};
  }
  /// NumbersAhead() of a column that is there.
  [[nodiscard]] virtual std::span<const double> CellsAhead(std::size_t /*column*/) const {
    return {};
  }
  /// NoneAhead() of a column that is there.
  [[nodiscard]] virtual bool IsUnstored(std::size_t /*column*/) const { return false; }
  /// What the table has in place of a missing column: "the header has a,b".
  [[nodiscard]] virtual std::string ColumnsThere() const = 0;

  std::string file_;
  std::size_t line_ = 0;
  std::vector<std::string> names_;  // asked for
  std::vector<std::size_t> place_;  // by asked column: where it stands
  /// By asked column: numbers of several rows, of which the current one is number `at_`, finite or
  /// NaN; null where the cells are text.
  std::vector<const double*> numbers_;
  std::size_t at_ = 0;
  std::vector<std::string> unknown_;
};

/// Adds the one warning about columns nobody knows.
void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings);

/// A number above 0, or NaN for an empty cell.
[[nodiscard]] double PositiveNumber(const TableReader& reader, std::size_t column);

/// Writes a table cell by cell, whatever it is stored in; it appears whole at Commit().
class TableWriter {
 public:
  virtual ~TableWriter() = default;

  virtual TableWriter& Text(std::string_view text) = 0;
  /// Text that is an id of the block: number `index` of its passes or its points.
  virtual TableWriter& Id(std::string_view text, std::uint32_t /*index*/) { return Text(text); }
  /// NaN is an empty cell. Infinity is refused (InputError), at the latest by EndPart() and
  /// Commit(): no table holds one.
  TableWriter& Number(double value) {
    if (next_cell_ < numbers_.size() && numbers_[next_cell_] != nullptr) {
      numbers_[next_cell_++][kept_rows_] = value;
    } else {
      PutNumber(value);
    }
    return *this;
  }
  template <std::integral T>
  TableWriter& Integer(T value) {
    if (next_cell_ < numbers_.size() && numbers_[next_cell_] != nullptr) {
      numbers_[next_cell_++][kept_rows_] = static_cast<double>(value);
    } else {
      PutInteger(static_cast<std::int64_t>(value));
    }
    return *this;
  }
  virtual TableWriter& Empty(std::size_t cells) = 0;
  TableWriter& Empty() { return Empty(1); }
  /// Ends the row; std::logic_error unless it has a cell for every column.
  virtual void EndRow() = 0;
  virtual void Commit() = 0;

  /// A writer of rows of this table that another thread may use beside this one: it keeps them
  /// until Append() writes them. Ids that the table is given the index of go to a part by Id().
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Part() = 0;
  /// Ends a part, by the thread that wrote its rows: what no table holds is refused.
  virtual void EndPart() {}
  /// Writes the rows of an ended Part() of this table behind those written before. It has none then
  /// and may be used again.
  virtual void Append(TableWriter* part) = 0;
  /// Rows that a part holds best.
  [[nodiscard]] virtual std::size_t rows_of_part() const = 0;

  // Of a part without rows that keeps columns: its rows as whole columns, in any order of the
  // columns, all of which are needed before EndRows().
  /// Takes the numbers of a column from where they stand, which they do until Append(): finite, or
  /// the NaN of std::numeric_limits. False where columns are not kept.
  [[nodiscard]] virtual bool LendNumbers(std::size_t /*column*/, std::span<const double>) {
    return false;
  }
  /// Where so many indices of ids that the table is given, or of IndexOf(), go; likewise.
  [[nodiscard]] virtual std::uint32_t* IndicesOf(std::size_t /*column*/, std::size_t /*rows*/) {
    return nullptr;
  }
  /// The index of a text in the part's own list for a column of text.
  [[nodiscard]] virtual std::uint32_t IndexOf(std::size_t /*column*/, std::string_view /*text*/) {
    return 0;
  }
  /// Ends the part.
  virtual void EndRows(std::size_t /*rows*/) {}

 protected:
  TableWriter() = default;
  TableWriter(TableWriter&&) = default;
  TableWriter& operator=(TableWriter&&) = default;
  virtual void PutNumber(double value) = 0;
  virtual void PutInteger(std::int64_t value) = 0;

  /// By column: where the numbers of its rows stand; null where the cells are text. Empty where
  /// rows are kept as text.
  std::vector<double*> numbers_;
  std::size_t next_cell_ = 0;  // of the row
  std::size_t kept_rows_ = 0;
};

/// Has `write(begin, end, out)` write the rows of [0, count), or what is as long as `per_piece`
/// says: pieces of so many on all threads. The rows stand in their order.
void WriteRows(std::size_t count,
               std::size_t per_piece,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, TableWriter*)>& write);

/// Throws InputError naming the file for a number that no table holds.
void RefuseInfinity(double value, std::string_view file);

/// Where the tables of a block or a result come from: a folder, one file of all (container.h) or
/// texts in memory.
class TableSource {
 public:
  explicit TableSource(FolderContent content) : content_(content) {}
  virtual ~TableSource() = default;
  /// Name for messages and text of a file that must be there.
  [[nodiscard]] virtual std::pair<std::string, std::string> Read(std::string_view file) const = 0;
  /// A table by its name without ending ("points"), or nothing if it does not stand there.
  [[nodiscard]] virtual std::unique_ptr<TableReader> Open(
      std::string_view table, std::span<const TableColumn> columns) const = 0;
  /// The name for messages of a table that must be there.
  [[nodiscard]] virtual std::string NameOf(std::string_view table) const = 0;
  /// The name that something takes that gives itself none.
  [[nodiscard]] virtual std::string DefaultName() const = 0;
  /// The ids that TableReader::IndexOfText() counts in; none where texts stand in their rows.
  [[nodiscard]] virtual BlockIds Ids() const { return {}; }
  /// A table that must be there.
  [[nodiscard]] std::unique_ptr<TableReader> Require(std::string_view table,
                                                     std::span<const TableColumn> columns) const;
  [[nodiscard]] FolderContent content() const { return content_; }

 protected:
  [[noreturn]] void FailMissing(const std::string& file, const char* what) const;
  FolderContent content_;
};

/// Where the tables of a block or a result are written: a folder or one file of all.
class TableSink {
 public:
  virtual ~TableSink() = default;
  /// A table with these of its columns; one is open at a time.
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Open(std::string_view table,
                                                          std::span<const TableColumn> columns) = 0;
  /// block.toml or summary.json, after the tables.
  virtual void WriteText(std::string_view file, std::string_view text) = 0;
  /// Where files go that are no tables; nothing where there is no folder.
  [[nodiscard]] virtual std::optional<std::filesystem::path> folder() const = 0;
};

}  // namespace sarblock
