// SPDX-License-Identifier: Apache-2.0
#include "pipe.h"

#include "sarblock/core/error.h"

#include <exception>
#include <vector>

#include "cancellation.h"
#include "parallel.h"
#include <oneapi/tbb/parallel_pipeline.h>

namespace sarblock {

void PipeInOrder(std::size_t at_once,
                 const std::function<bool(std::size_t)>& next,
                 const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& take) {
  const ProgressSink* const sink = CancellationScope::Current();
  std::vector<std::exception_ptr> errors(at_once);
  std::size_t items = 0;
  bool failed = false;
  // An item is begun when fewer than `at_once` are in the pipe, which they leave in order: its
  // place is free then.
  const auto begin = [&](tbb::flow_control& control) {
    const std::size_t place = items++ % at_once;
    try {
      if (sink != nullptr && sink->Cancelled()) throw Interrupted("a loop over rows");
      if (failed || !next(place)) control.stop();
    } catch (...) {
      errors[place] = std::current_exception();
      failed = true;
    }
    return place;
  };
  const auto go_on = [&](std::size_t place) {
    try {
      if (!errors[place]) work(place);
    } catch (...) {
      errors[place] = std::current_exception();
    }
    return place;
  };
  const auto end = [&](std::size_t place) {
    if (errors[place]) std::rethrow_exception(errors[place]);
    take(place);
  };
  tbb::task_group_context context;
  tbb::parallel_pipeline(
      at_once,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, begin) &
          tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, go_on) &
          tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, end),
      context);
  if (context.is_group_execution_cancelled()) throw Interrupted("a loop over rows");
}

std::size_t ItemsAtOnce() { return 1 + static_cast<std::size_t>(ThreadsAllowed()); }

}  // namespace sarblock
