// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace sarblock {

/// Walks through an HDF5 file in a process of its own (hdf5_walk.cc): every group, attribute and
/// dataset, of large datasets the first and the last values. libhdf5 does not bear bytes that a
/// disk or a line has changed everywhere: it reads beyond its memory, frees what it has not, or
/// never ends. What it bears there, it bears here. Throws InputError where the process does not
/// come to its end or cannot be started, Interrupted where CancellationScope::Current() asks for
/// it. What the walk cannot open is no error: it is named when it is needed. `bytes` is the file's
/// length, which bounds the time and the memory of the walk. Nothing at all after
/// SetHdf5Trial(false).
///
/// Callers may have threads that hold locks of any library. So nothing is forked: the program of
/// the walk is a part of this library, started by posix_spawn().
void TryHdf5(const std::string& path, std::uint64_t bytes);

/// Whether TryHdf5() does anything; true at first.
void SetHdf5Trial(bool on);

/// What the program of the walk says on its standard output, in this order.
inline constexpr const char* kWalkBegins = "begun ";
inline constexpr const char* kWalkEnds = "whole";

}  // namespace sarblock
