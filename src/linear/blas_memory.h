// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock::dense {

/// Takes the memory of OpenBLAS for so many threads that call it, where the addresses of this
/// process are limited (ulimit -v): 128 MiB each, which it would ask for without end where they are
/// refused. Throws InputError where there is not as much. Nothing without a limit.
void TakeBlasMemory(int threads);

}  // namespace sarblock::dense
