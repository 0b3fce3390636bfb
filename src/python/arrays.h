// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"
#include "sarblock/files/block_file.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace sarblock::python {

/// An array over numbers that `owner`, a Python object, holds and never changes: no copy, read
/// only. `strides` are in bytes.
template <typename Number>
[[nodiscard]] pybind11::array View(const pybind11::handle& owner,
                                   const Number* data,
                                   std::vector<pybind11::ssize_t> shape,
                                   std::vector<pybind11::ssize_t> strides) {
  pybind11::array array(
      pybind11::dtype::of<Number>(), std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(false);
  return array;
}

template <typename Number>
[[nodiscard]] pybind11::array View(const pybind11::handle& owner,
                                   const std::vector<Number>& numbers) {
  return View(owner,
              numbers.data(),
              {static_cast<pybind11::ssize_t>(numbers.size())},
              {static_cast<pybind11::ssize_t>(sizeof(Number))});
}

/// The same, or None for a column that is not there.
template <typename Number>
[[nodiscard]] pybind11::object OptionalView(const pybind11::handle& owner,
                                            const std::vector<Number>& numbers) {
  if (numbers.empty()) return pybind11::none();
  return View(owner, numbers);
}

/// One number of every row of a list of structures; `first` is that of the first row.
template <typename Number, typename Row>
[[nodiscard]] pybind11::array ColumnView(const pybind11::handle& owner,
                                         const std::vector<Row>& rows,
                                         Number Row::*member) {
  static const Row kNothing{};
  const Row& first = rows.empty() ? kNothing : rows.front();
  return View(owner,
              &(first.*member),
              {static_cast<pybind11::ssize_t>(rows.size())},
              {static_cast<pybind11::ssize_t>(sizeof(Row))});
}

/// The same for vectors of three: (rows, 3).
template <typename Row>
[[nodiscard]] pybind11::array VectorView(const pybind11::handle& owner,
                                         const std::vector<Row>& rows,
                                         Eigen::Vector3d Row::*member) {
  static const Row kNothing{};
  const Row& first = rows.empty() ? kNothing : rows.front();
  return View(owner,
              (first.*member).data(),
              {static_cast<pybind11::ssize_t>(rows.size()), 3},
              {static_cast<pybind11::ssize_t>(sizeof(Row)),
               static_cast<pybind11::ssize_t>(sizeof(double))});
}
[[nodiscard]] pybind11::array VectorView(const pybind11::handle& owner,
                                         const std::vector<Eigen::Vector3d>& rows);
/// States of a flight: time, position and velocity, (states, 7).
[[nodiscard]] pybind11::array StatesView(const pybind11::handle& owner,
                                         const std::vector<StateVector>& states);

/// Matrices (rows, 3, 3) of six numbers each: a copy. `first` is where the first
/// row has its numbers, the others follow `stride` bytes apart.
[[nodiscard]] pybind11::array Covariances(std::size_t rows,
                                          const SymmetricEnu* first,
                                          std::size_t stride);

/// A string of Python; bytes that are not UTF-8 are decoded by `surrogateescape`.
[[nodiscard]] pybind11::object TextObject(std::string_view text);
[[nodiscard]] pybind11::list TextList(const std::vector<std::string>& texts);
/// An array of such strings; of objects where a text has more than 64 characters.
[[nodiscard]] pybind11::array Texts(std::size_t count,
                                    const std::function<std::string_view(std::size_t)>& of);

/// A column of a table as the library reads it, with the object that owns its numbers.
struct FixedColumn {
  files::ArrayColumn column;
  pybind11::object holder;
};
/// Throws InputError for an array that is no column: not one dimension, no numbers, no strings.
[[nodiscard]] FixedColumn ColumnOf(const std::string& table,
                                   const std::string& name,
                                   const pybind11::array& array);
/// The same for indices into texts that are elsewhere.
[[nodiscard]] FixedColumn IndexColumnOf(const std::string& table,
                                        const std::string& name,
                                        const pybind11::array& array,
                                        std::shared_ptr<const IdTable> texts);

}  // namespace sarblock::python
