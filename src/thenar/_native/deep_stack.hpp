// Operations on diagrams go as deep as there are levels, and may take long: short ones run where they are called, the
// others on a thread with a stack deep enough, while the calling thread looks out for Ctrl-C, limits and progress.
#pragma once

#include <nanobind/nanobind.h>
#include <pthread.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>

#include "bindings.hpp"
#include "diagrams.hpp"

namespace thenar {

struct Cancelled {};

// Run `work` and wait for it; throws what it throws, or what the ticker throws meanwhile.
inline void on_deep_stack(Forest& forest, Ticker& ticker, const std::function<void()>& work) {
  struct Shared {
    const std::function<void()>& work;
    std::mutex mutex;
    std::condition_variable done_changed;
    bool done = false;
    std::exception_ptr error;
    std::atomic<bool> cancel = false;
    std::atomic<u64> nodes = 0, steps = 0;
  } shared{work};
  Ticker inner({}, [&](u64 nodes, u64 steps) {
    shared.nodes = nodes;
    shared.steps = steps;
    if (shared.cancel) throw Cancelled();
  });
  forest.ticker = &inner;
  forest.busy = true;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  // Two frames a level and more, each below a kilobyte; memory that is not touched costs nothing.
  pthread_attr_setstacksize(&attributes, (u64{16} << 20) + u64{8192} * forest.n_levels());
  pthread_t thread;
  std::exception_ptr stopped;
  auto run = [](void* argument) -> void* {
    auto& s = *static_cast<Shared*>(argument);
    try {
      s.work();
    } catch (...) {
      s.error = std::current_exception();
    }
    std::lock_guard lock(s.mutex);
    s.done = true;
    s.done_changed.notify_one();
    return nullptr;
  };
  {
    Released free;
    const bool started = pthread_create(&thread, &attributes, run, &shared) == 0;
    if (!started) {
      shared.done = true;
      shared.error = std::make_exception_ptr(std::bad_alloc());
    }
    std::unique_lock lock(shared.mutex);
    while (!shared.done_changed.wait_for(lock, std::chrono::milliseconds(50), [&] { return shared.done; })) {
      if (stopped) continue;
      lock.unlock();
      try {
        ticker.tick(1 << 20, shared.nodes, shared.steps);
      } catch (...) {
        stopped = std::current_exception();
        shared.cancel = true;
      }
      lock.lock();
    }
    lock.unlock();
    if (started) pthread_join(thread, nullptr);
    if (!shared.error) shared.error = stopped;
  }
  pthread_attr_destroy(&attributes);
  forest.ticker = nullptr;
  forest.busy = false;
  for (Node n : std::exchange(forest.dropped_meanwhile, {})) forest.drop(n);
  if (forest.left_meanwhile) forest.leave_families(std::exchange(forest.left_meanwhile, 0));
  if (shared.error) {
    forest.stack().clear();
    std::rethrow_exception(stopped ? stopped : shared.error);
  }
}

// Before each operation: the forest must not be at work for another thread, and has its garbage collected if due.
inline void ready(Forest& f) {
  if (f.busy) throw std::runtime_error("these diagrams are at work in another thread; give each thread its own synthesis");
  if (f.collection_is_due()) f.collect();
}

// Bytes of stack that the calling thread has left, as far as that is known.
inline u64 stack_left() {
#ifdef __linux__
  thread_local const char* const lowest = [] {
    void* low = nullptr;
    size_t size = 0;
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes)) return static_cast<char*>(nullptr);
    pthread_attr_getstack(&attributes, &low, &size);
    pthread_attr_destroy(&attributes);
    return static_cast<char*>(low);
  }();
  const char* here = static_cast<const char*>(__builtin_frame_address(0));
  if (lowest) return static_cast<u64>(here - lowest);
#endif
  return u64{512} << 10;  // the least that threads are given by default
}

constexpr u64 kShort = 1 << 16;  // steps: a few milliseconds

// Do one operation: where it stands if it is short and the stack deep enough, else on a deep stack. It may be begun twice.
template <class F>
auto run(Forest& f, Ticker& ticker, F operation, u64 few = kShort) {
  constexpr u64 kPerLevel = 1024, kBeside = 64 << 10;  // bytes of stack
  if (kPerLevel * f.n_levels() + kBeside < stack_left()) {
    try {
      const StepBudget budget(f, few);
      return operation();
    } catch (const OutOfSteps&) {
      f.stack().clear();
    }
    if (f.work > f.last_step) throw OutOfSteps();
  }
  decltype(operation()) result{};
  on_deep_stack(f, ticker, [&] { result = operation(); });
  return result;
}

// Many short operations are long, too: tell the ticker of those done by now. It may call Python, which may do anything,
// so that only then the forest is made ready.
inline void prepare(Forest& f, Ticker& ticker) {
  ticker.tick((f.work - std::exchange(f.told, f.work)) * Forest::kCostOfStep + 1, f.n_alive(), f.work);
  ready(f);
}

template <class F>
auto operate(Forest& f, Ticker& ticker, F operation, u64 few = kShort) {
  prepare(f, ticker);
  return run(f, ticker, operation, few);
}

// The same for what is given no ticker of its own.
template <class F>
auto operate(Forest& f, F operation) {
  Ticker signals({}, [](u64, u64) {
    with_gil([] {
      if (PyErr_CheckSignals()) throw nanobind::python_error();
    });
  });
  const std::shared_ptr<Ticker> watch = f.watch;  // may be given another one meanwhile
  return operate(f, watch ? *watch : signals, operation);
}

}  // namespace thenar
