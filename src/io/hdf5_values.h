// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace sarblock {

struct OpenedHdf5;  ///< src/io/hdf5_input.h

/// Numbers of a dataset with one, two or three dimensions, the last one running fastest.
struct Hdf5Array {
  std::vector<std::size_t> size;  ///< one number a dimension
  std::vector<double> values;     ///< finite
};

/// Datasets of an HDF5 file of others, by paths such as "/science/LSAR/identification". Groups and
/// datasets must stand in the file itself, links are refused; what is read is bounded by the size
/// of the file before any memory is taken. Everything that is wrong throws InputError with the file
/// and the path.
class Hdf5Values {
 public:
  /// Throws where the file cannot be opened, is cut off or is no HDF5 file.
  explicit Hdf5Values(const std::string& file);
  ~Hdf5Values();

  [[nodiscard]] const std::string& file() const;
  /// Whether a group or dataset stands there.
  [[nodiscard]] bool Has(const std::string& path) const;
  /// One text, of fixed or variable length.
  [[nodiscard]] std::string Text(const std::string& path) const;
  /// One number.
  [[nodiscard]] double Number(const std::string& path) const;
  /// All numbers of a dataset of `rank` dimensions; more than `most` are refused, and any that is
  /// not finite.
  [[nodiscard]] Hdf5Array Numbers(const std::string& path, int rank, std::size_t most) const;
  /// A text attribute of a dataset.
  [[nodiscard]] std::string TextAttribute(const std::string& path, const std::string& name) const;

  [[noreturn]] void Fail(const std::string& path, const std::string& problem) const;

 private:
  std::unique_ptr<OpenedHdf5> opened_;
};

}  // namespace sarblock
