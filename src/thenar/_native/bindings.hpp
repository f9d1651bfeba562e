// What the binding files share: arrays in, arrays out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <unistd.h>

#include <exception>
#include <utility>
#include <vector>

#include "common.hpp"

namespace thenar {

template <class T>
using In = nanobind::ndarray<const T, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;
template <class T>
using Out = nanobind::ndarray<nanobind::numpy, T, nanobind::ndim<1>>;

// Hand a vector over to NumPy without a copy.
template <class T>
Out<T> give(std::vector<T>&& values) {
  auto* owned = new std::vector<T>(std::move(values));
  nanobind::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Out<T>(owned->data(), {owned->size()}, owner);
}

// When the interpreter ends, Python unwinds every other thread that asks for the GIL, which C++ does not survive, nor what
// works for the thread elsewhere; later there is no interpreter to ask. Such a thread waits for the end of the process.
template <class F>
void until_python_ends(F f) {
  while (!Py_IsInitialized()) ::pause();
  try {
    f();
  } catch (const std::exception&) {
    throw;
  } catch (...) {  // no exception of ours
    while (true) ::pause();
  }
}

// Run `f`, which throws nothing but standard exceptions, with the GIL.
template <class F>
void with_gil(F f) {
  struct Held {
    PyGILState_STATE state = PyGILState_Ensure();
    ~Held() { PyGILState_Release(state); }
  };
  until_python_ends([&] {
    const Held held;
    until_python_ends(f);
  });
}

// Lets other Python threads run as long as it lives.
class Released {
 public:
  Released() : state_(PyEval_SaveThread()) {}
  ~Released() {
    until_python_ends([&] { PyEval_RestoreThread(state_); });
  }
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* state_;
};

}  // namespace thenar

void bind_symbolic(nanobind::module_& m);
