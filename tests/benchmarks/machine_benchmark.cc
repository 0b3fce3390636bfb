// SPDX-License-Identifier: Apache-2.0
// What this machine can do on one thread, to stand beside the times of the others: memory (triad
// a = b + s c of STREAM, 24 bytes an element) and the BLAS and LAPACK kernels of the factor. Best
// of a few runs by CPU time. Run by scripts/bench.sh machine.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>
#include <vector>

#include "linear/dense.h"

namespace {

double Cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Best_s(int repeats, const std::function<void()>& prepare, const std::function<void()>& run) {
  double best_s = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    prepare();
    const double begin_s = Cpu_s();
    run();
    best_s = std::min(best_s, Cpu_s() - begin_s);
  }
  return best_s;
}

void Triad() {
  constexpr std::size_t kElements = std::size_t{1} << 25;
  std::vector<double> a(kElements, 0.0), b(kElements, 1.5), c(kElements, 2.5);
  double scale = 3.25;
  const auto run = [&] {
    for (std::size_t i = 0; i < kElements; ++i) a[i] = b[i] + scale * c[i];
    scale += a[kElements / 2] * 1e-9;  // the next pass depends on this one
  };
  const double time_s = Best_s(
      7, [] {}, run);
  std::printf("triad,%.1f,GB/s\n", 24.0 * static_cast<double>(kElements) / time_s / 1e9);
}

void Dense() {
  constexpr int n = 2048;
  const double cube = static_cast<double>(n) * n * n;
  const std::size_t elements = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  std::vector<double> a(elements), b(elements), c(elements);
  for (std::size_t i = 0; i < elements; ++i) {
    a[i] = 1.0 / static_cast<double>(1 + i % 97);
    b[i] = 1.0 / static_cast<double>(1 + i % 89);
  }
  const double product_s = Best_s(
      5, [] {}, [&] { sarblock::dense::Product(n, n, n, a.data(), n, b.data(), n, c.data(), n); });
  std::printf("dgemm_%d,%.1f,GFlop/s\n", n, 2.0 * cube / product_s / 1e9);
  const auto prepare = [&] {
    c = a;
    for (std::size_t i = 0; i < elements; i += n + 1) c[i] = 2.0 * n;
  };
  int failed = 0;
  const double factor_s =
      Best_s(5, prepare, [&] { failed += sarblock::dense::Factor(n, c.data(), n); });
  std::printf("dpotrf_%d,%.1f,GFlop/s\n", n, failed > 0 ? 0.0 : cube / 3.0 / factor_s / 1e9);
}

}  // namespace

int main() {
  sarblock::dense::UseOneBlasThread();
  std::puts("kernel,rate,unit");
  Triad();
  Dense();
  return 0;
}
