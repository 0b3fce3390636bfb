// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <hdf5.h>

// Damage to an HDF5 file of a block or a result as people, programs and disks do it, as lines of
// text:
//
//   set PATH ROW NUMBER      one value of a dataset of numbers or indices, counted over all
//                            dimensions
//   extend PATH ROWS         claims more rows than are stored, or fewer
//   delete PATH              takes a dataset, a group or (PATH without a slash) an attribute away
//   floats PATH ROWS         a dataset of zeros in its place; likewise
//   integers PATH ROWS
//   words PATH ROWS          strings of variable length
//   matrix PATH ROWS         ROWS x 2 numbers
//   cube PATH ROWS           ROWS x 2 x 2 numbers
//   scalar PATH              one number
//   word PATH TEXT...        one string in its place
//   units PATH TEXT...       the attribute "units" of a dataset
//   external PATH ROWS       numbers in another file
//   link PATH TARGET         a soft link
//   text NAME TEXT...        an attribute
//   cut BYTES                the file ends there
//
// A line that cannot be done is left out: the fuzzer writes many.
namespace sarblock::fuzz {

class ContainerEdit {
 public:
  ContainerEdit(const std::filesystem::path& path, std::string_view lines) : path_(path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    std::istringstream in{std::string(lines)};
    for (std::string line; std::getline(in, line);) Apply(line);
    if (file_ >= 0) H5Fclose(file_);
    if (cut_ >= 0 && cut_ < static_cast<long long>(std::filesystem::file_size(path))) {
      std::filesystem::resize_file(path, static_cast<std::uintmax_t>(cut_));
    }
  }

 private:
  void Apply(const std::string& line) {
    std::istringstream in(line);
    std::string what, path;
    in >> what;
    if (what == "cut") {
      if (!(in >> cut_)) cut_ = -1;
      return;
    }
    if (!(in >> path) || path == "/" || path == ".") return;
    if (what == "set") {
      hsize_t row = 0;
      std::string number;
      if (in >> row >> number) Set(path, row, std::strtod(number.c_str(), nullptr));
    } else if (what == "delete") {
      if (path.starts_with('/')) {
        H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
      } else {
        H5Adelete(file_, path.c_str());
      }
    } else if (what == "link") {
      std::string target;
      in >> target;
      H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
      H5Lcreate_soft(target.c_str(), file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    } else if (what == "text" || what == "units" || what == "word") {
      std::string text;
      std::getline(in, text);
      if (what == "text") {
        SetText(file_, path, text);
      } else if (what == "word") {
        SetWord(path, text.substr(std::min<std::size_t>(1, text.size())));
      } else {
        const hid_t dataset = H5Oopen(file_, path.c_str(), H5P_DEFAULT);
        SetText(dataset, "units", text.substr(std::min<std::size_t>(1, text.size())));
        if (dataset >= 0) H5Oclose(dataset);
      }
    } else if (what == "scalar") {
      Make(path, H5T_NATIVE_DOUBLE, {}, {}, false);
    } else {
      hsize_t rows = 0;
      if (in >> rows) Resize(what, path, rows);
    }
  }

  void Set(const std::string& path, hsize_t row, double value) {
    const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    const hsize_t one = 1;
    const int rank = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> size(rank > 0 ? static_cast<std::size_t>(rank) : 0), at(size.size());
    if (rank > 0) H5Sget_simple_extent_dims(space, size.data(), nullptr);
    for (std::size_t i = size.size(); i > 0 && size[i - 1] > 0; --i) {
      at[i - 1] = i > 1 ? row % size[i - 1] : row;
      row /= size[i - 1];
    }
    if (rank > 0) H5Sselect_elements(space, H5S_SELECT_SET, 1, at.data());
    const hid_t memory = H5Screate_simple(1, &one, nullptr);
    if (H5Sselect_valid(space) > 0 && H5Sget_select_npoints(space) == 1) {
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, &value);
    }
    H5Sclose(memory);
    H5Sclose(space);
    H5Dclose(dataset);
  }

  void Resize(const std::string& what, const std::string& path, hsize_t rows) {
    if (what == "extend") {
      // Datasets of a small table do not grow: one that does takes its place, its rows unwritten.
      Make(path, H5T_NATIVE_DOUBLE, {rows}, {H5S_UNLIMITED}, false);
      return;
    }
    if (rows > 1000) return;
    if (what == "floats") Make(path, H5T_NATIVE_DOUBLE, {rows}, {rows}, false);
    if (what == "integers") Make(path, H5T_NATIVE_INT, {rows}, {rows}, false);
    if (what == "cube") Make(path, H5T_NATIVE_DOUBLE, {rows, 2, 2}, {rows, 2, 2}, false);
    if (what == "matrix") Make(path, H5T_NATIVE_DOUBLE, {rows, 2}, {rows, 2}, false);
    if (what == "external") Make(path, H5T_NATIVE_DOUBLE, {rows}, {rows}, true);
    if (what == "words") {
      const hid_t type = H5Tcopy(H5T_C_S1);
      H5Tset_size(type, H5T_VARIABLE);
      Make(path, type, {rows}, {rows}, false);
      H5Tclose(type);
    }
  }

  void Make(const std::string& path,
            hid_t type,
            const std::vector<hsize_t>& size,
            const std::vector<hsize_t>& most,
            bool external) {
    H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
    const hid_t space =
        size.empty() ? H5Screate(H5S_SCALAR)
                     : H5Screate_simple(static_cast<int>(size.size()), size.data(), most.data());
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 1000;
    if (!most.empty() && most[0] == H5S_UNLIMITED) {
      H5Pset_chunk(creation, 1, &chunk);
    } else if (external) {
      H5Pset_external(creation, "other.bin", 0, 8 * size[0]);
    } else {
      H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    }
    const hid_t dataset =
        H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    if (dataset >= 0) H5Dclose(dataset);
    H5Pclose(creation);
    H5Sclose(space);
  }

  void SetWord(const std::string& path, const std::string& text) {
    H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size() + 1);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t dataset =
        H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (dataset >= 0) {
      H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str());
      H5Dclose(dataset);
    }
    H5Sclose(space);
    H5Tclose(type);
  }

  static void SetText(hid_t object, const std::string& name, const std::string& text) {
    H5Adelete(object, name.c_str());
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size() + 1);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute >= 0) {
      H5Awrite(attribute, type, text.c_str());
      H5Aclose(attribute);
    }
    H5Sclose(space);
    H5Tclose(type);
  }

  std::filesystem::path path_;
  hid_t file_ = -1;
  long long cut_ = -1;
};

}  // namespace sarblock::fuzz
