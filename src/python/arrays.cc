// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

namespace sarblock::python {
namespace {

namespace py = pybind11;

constexpr char32_t kEscaped = 0xdc00;  // plus the byte that is no UTF-8

/// The next character of a text that is not empty; takes it away.
char32_t NextCharacter(std::string_view* text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>((*text)[i]); };
  const unsigned char lead = byte(0);
  const std::size_t length = lead < 0x80 ? 1 : lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  bool good = lead < 0x80 || (lead >= 0xc2 && lead < 0xf5 && text->size() >= length);
  char32_t character = length == 1 ? lead : lead & (0x7fU >> length);
  for (std::size_t i = 1; good && i < length; ++i) {
    good = (byte(i) & 0xc0U) == 0x80;
    character = (character << 6U) | (byte(i) & 0x3fU);
  }
  constexpr std::array<char32_t, 5> kMin{0, 0, 0x80, 0x800, 0x10000};
  good = good && character >= kMin[length] && character < 0x110000 &&
         !(character >= 0xd800 && character < 0xe000);
  text->remove_prefix(good ? length : 1);
  return good ? character : kEscaped + lead;
}

void AppendCharacter(char32_t character, std::string* text) {
  const auto put = [text](char32_t byte) { text->push_back(static_cast<char>(byte)); };
  const auto more = [&](unsigned shift) { put(0x80U | ((character >> shift) & 0x3fU)); };
  if (character < 0x80) {
    put(character);
  } else if (character < 0x800) {
    put(0xc0U | (character >> 6U));
    more(0);
  } else if (character >= kEscaped + 0x80 && character < kEscaped + 0x100) {
    put(character - kEscaped);
  } else if (character < 0x10000) {
    put(0xe0U | (character >> 12U));
    more(6);
    more(0);
  } else {
    put(0xf0U | (character >> 18U));
    more(12);
    more(6);
    more(0);
  }
}

std::size_t CountCharacters(std::string_view text) {
  const auto plain = [](char c) { return static_cast<unsigned char>(c) < 0x80; };
  if (std::all_of(text.begin(), text.end(), plain)) return text.size();
  std::size_t count = 0;
  while (!text.empty()) {
    static_cast<void>(NextCharacter(&text));
    ++count;
  }
  return count;
}

[[noreturn]] void Refuse(const std::string& table,
                         const std::string& name,
                         const std::string& problem) {
  throw InputError(table + "." + name, problem);
}

[[noreturn]] void RefuseIndex(const std::string& table,
                              const std::string& name,
                              py::ssize_t row,
                              const std::string& index,
                              std::size_t count) {
  Refuse(table,
         name + "[" + std::to_string(row) + "]",
         "must be an index from 0 to below " + std::to_string(count) + ", got " + index);
}

void RequireOneDimension(const std::string& table,
                         const std::string& name,
                         const py::array& array) {
  if (array.ndim() == 1) return;
  Refuse(table, name, "has " + std::to_string(array.ndim()) + " dimensions, one is needed");
}

/// Texts numbered by first occurrence; the number of the text in each row.
class TextCollector {
 public:
  explicit TextCollector(std::size_t rows) : indices_(rows) {}
  void Set(std::size_t row, std::string_view text) { indices_[row] = texts_.FindOrAppend(text); }
  FixedColumn Finish(const std::string& name) && {
    struct Kept {
      IdTable texts;
      std::vector<std::uint32_t> indices;
    };
    auto kept = std::make_shared<Kept>(Kept{std::move(texts_), std::move(indices_)});
    FixedColumn out;
    out.column.name = name;
    out.column.texts = std::shared_ptr<const IdTable>(kept, &kept->texts);
    out.column.indices = kept->indices;
    return out;
  }

 private:
  IdTable texts_;
  std::vector<std::uint32_t> indices_;
};

FixedColumn FixedTexts(const std::string& name, const py::array& array, bool bytes) {
  const auto rows = static_cast<std::size_t>(array.shape(0));
  const auto width = static_cast<std::size_t>(array.itemsize());
  TextCollector collector(rows);
  std::string text;
  for (std::size_t row = 0; row < rows; ++row) {
    const char* cell = static_cast<const char*>(array.data(static_cast<py::ssize_t>(row)));
    text.clear();
    if (bytes) {
      text.assign(cell, strnlen(cell, width));
    } else {
      for (std::size_t at = 0; at < width; at += sizeof(char32_t)) {
        char32_t character = 0;
        std::memcpy(&character, cell + at, sizeof character);
        if (character == 0) break;
        if (character < 0x80) {
          text += static_cast<char>(character);
        } else {
          AppendCharacter(character, &text);
        }
      }
    }
    collector.Set(row, text);
  }
  return std::move(collector).Finish(name);
}

FixedColumn ObjectTexts(const std::string& table, const std::string& name, const py::array& array) {
  const auto rows = static_cast<std::size_t>(array.shape(0));
  TextCollector collector(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    PyObject* cell = nullptr;
    std::memcpy(&cell, array.data(static_cast<py::ssize_t>(row)), sizeof cell);
    if (cell == nullptr || PyUnicode_Check(cell) == 0) {
      Refuse(table,
             name + "[" + std::to_string(row) + "]",
             std::string("is a ") + (cell == nullptr ? "None" : Py_TYPE(cell)->tp_name) +
                 ", a text is needed");
    }
    const auto encoded = py::reinterpret_steal<py::bytes>(
        PyUnicode_AsEncodedString(cell, "utf-8", "surrogateescape"));
    if (!encoded) throw py::error_already_set();
    collector.Set(row, std::string_view(encoded));
  }
  return std::move(collector).Finish(name);
}

}  // namespace

py::object TextObject(std::string_view text) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
}

py::list TextList(const std::vector<std::string>& texts) {
  py::list out;
  for (const std::string& text : texts) out.append(TextObject(text));
  return out;
}

py::array VectorView(const py::handle& owner, const std::vector<Eigen::Vector3d>& rows) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return View(
      owner,
      reinterpret_cast<const double*>(rows.data()),
      {static_cast<py::ssize_t>(rows.size()), 3},
      {3 * static_cast<py::ssize_t>(sizeof(double)), static_cast<py::ssize_t>(sizeof(double))});
}

py::array StatesView(const py::handle& owner, const std::vector<StateVector>& states) {
  static_assert(sizeof(StateVector) == 7 * sizeof(double));
  return View(
      owner,
      reinterpret_cast<const double*>(states.data()),
      {static_cast<py::ssize_t>(states.size()), 7},
      {static_cast<py::ssize_t>(sizeof(StateVector)), static_cast<py::ssize_t>(sizeof(double))});
}

py::array Covariances(std::size_t rows, const SymmetricEnu* first, std::size_t stride) {
  py::array_t<double> out({static_cast<py::ssize_t>(rows), py::ssize_t{3}, py::ssize_t{3}});
  double* to = out.mutable_data();
  constexpr std::array<std::size_t, 9> kElement{0, 3, 4, 3, 1, 5, 4, 5, 2};
  const char* at = reinterpret_cast<const char*>(first);
  for (std::size_t row = 0; row < rows; ++row, at += stride) {
    SymmetricEnu from;
    std::memcpy(&from, at, sizeof from);
    for (const std::size_t element : kElement) *to++ = from[element];
  }
  return out;
}

py::array Texts(std::size_t count, const std::function<std::string_view(std::size_t)>& of) {
  constexpr std::size_t kWidest = 64;
  std::size_t width = 1;
  for (std::size_t i = 0; i < count; ++i) width = std::max(width, CountCharacters(of(i)));
  const auto rows = static_cast<py::ssize_t>(count);
  if (width > kWidest) {
    py::list texts;
    for (std::size_t i = 0; i < count; ++i) texts.append(TextObject(of(i)));
    return py::module_::import("numpy").attr("array")(texts, "object");
  }
  py::array out(py::dtype("U" + std::to_string(width)), std::vector<py::ssize_t>{rows});
  auto* to = static_cast<char*>(out.mutable_data());
  std::memset(to, 0, count * width * sizeof(char32_t));
  for (std::size_t i = 0; i < count; ++i, to += width * sizeof(char32_t)) {
    std::string_view text = of(i);
    for (std::size_t at = 0; !text.empty(); at += sizeof(char32_t)) {
      const char32_t character = NextCharacter(&text);
      std::memcpy(to + at, &character, sizeof character);
    }
  }
  return out;
}

FixedColumn ColumnOf(const std::string& table, const std::string& name, const py::array& array) {
  RequireOneDimension(table, name, array);
  switch (array.dtype().kind()) {
    case 'U':
      return FixedTexts(name, array, false);
    case 'S':
      return FixedTexts(name, array, true);
    case 'O':
      return ObjectTexts(table, name, array);
    case 'b':
    case 'i':
    case 'u':
    case 'f':
      break;
    default:
      Refuse(table,
             name,
             "is an array of " + std::string(py::str(array.dtype())) +
                 ", numbers or strings are needed");
  }
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>(array);
  FixedColumn out;
  out.column.name = name;
  out.column.cells = {numbers.data(), static_cast<std::size_t>(numbers.size())};
  out.holder = numbers;
  return out;
}

FixedColumn IndexColumnOf(const std::string& table,
                          const std::string& name,
                          const py::array& array,
                          std::shared_ptr<const IdTable> texts) {
  RequireOneDimension(table, name, array);
  if (array.dtype().kind() != 'i' && array.dtype().kind() != 'u') {
    Refuse(table,
           name,
           "is an array of " + std::string(py::str(array.dtype())) + ", integers are needed");
  }
  // Those of a block are of this type and fixed: they are read in place.
  using Indices = py::array_t<std::uint32_t, py::array::c_style>;
  if (!py::isinstance<Indices>(array)) {
    const auto given = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array);
    for (py::ssize_t i = 0; i < given.size(); ++i) {
      if (given.data()[i] < 0 || given.data()[i] > std::numeric_limits<std::uint32_t>::max()) {
        RefuseIndex(table, name, i, std::to_string(given.data()[i]), texts->size());
      }
    }
  }
  auto indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>(array);
  // Nothing may change them once they are checked.
  if (indices.writeable()) indices = indices.attr("copy")();
  for (py::ssize_t i = 0; i < indices.size(); ++i) {
    if (indices.data()[i] >= texts->size()) {
      RefuseIndex(table, name, i, std::to_string(indices.data()[i]), texts->size());
    }
  }
  FixedColumn out;
  out.column.name = name.substr(0, name.size() - std::string_view("_index").size());
  out.column.indices = {indices.data(), static_cast<std::size_t>(indices.size())};
  out.column.texts = std::move(texts);
  out.holder = indices;
  return out;
}

}  // namespace sarblock::python
