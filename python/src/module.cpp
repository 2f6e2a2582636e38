// The module ferrule._core: how C++ and Python speak of errors, arrays and threads.
#include <dlfcn.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <filesystem>

#include "bindings.hpp"
#include "capture/episode.hpp"
#include "sim/base/data_folder.hpp"

namespace ferrule {

// In the package, wherever it was installed.
std::string data_folder() {
  Dl_info self;
  ::dladdr(reinterpret_cast<const void*>(&data_folder), &self);
  return (std::filesystem::path(self.dli_fname).parent_path() / "share/ferrule").string();
}

namespace python {
namespace {

std::atomic<bool> forked = false;

// Raised where a C++ `Error` is thrown, with its text, which may hold bytes of a file that are
// none.
template <class Error>
void add_error(nb::module_& module, const char* name, PyObject* base, const char* doc) {
  const nb::exception<Error> type(module, name, base);
  type.attr("__doc__") = doc;
  const auto translate = [](const std::exception_ptr& thrown, void* raised) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& error) {
      const std::string text = error.what();
      const auto size = static_cast<Py_ssize_t>(text.size());
      const nb::object shown = nb::steal(PyUnicode_DecodeUTF8(text.data(), size, "replace"));
      PyErr_SetObject(static_cast<PyObject*>(raised), shown.ptr());
    }
  };
  nb::register_exception_translator(translate, type.ptr());
}

}  // namespace

int threads_here(int threads) noexcept {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return forked ? 1 : threads > 0 ? std::min(threads, cores) : cores;
}

Eigen::VectorXd numbers(nb::handle from, Eigen::Index count, const char* what) {
  const auto refuse = [&](const std::string& got) {
    throw nb::value_error(
        (std::string(what) + ": expected " + std::to_string(count) + " numbers, got " + got)
            .c_str());
  };
  Numbers values;
  if (nb::ndarray_check(from)) {
    if (!nb::try_cast(from, values)) refuse("an array of something else");
    if (values.ndim() != 1 || values.shape(0) != static_cast<std::size_t>(count)) {
      std::string shape;
      for (std::size_t i = 0; i < values.ndim(); ++i)
        shape += (i ? ", " : "") + std::to_string(values.shape(i));
      refuse("an array of shape (" + shape + ")");
    }
    return Eigen::Map<const Eigen::VectorXd>(values.data(), count);
  }
  std::vector<double> list;
  if (!nb::try_cast(from, list)) refuse(nb::repr(from).c_str());
  if (list.size() != static_cast<std::size_t>(count)) refuse(std::to_string(list.size()));
  return Eigen::Map<const Eigen::VectorXd>(list.data(), count);
}

Array array(const double* values, std::vector<std::size_t> shape) {
  std::size_t size = 1;
  for (const std::size_t n : shape) size *= n;
  using Values = std::vector<double>;
  auto copy = std::make_unique<Values>(values, values + size);
  double* const first = copy->data();
  const nb::capsule owner(
      copy.get(), [](void* p) noexcept { std::default_delete<Values>()(static_cast<Values*>(p)); });
  copy.release();  // it is the capsule's from here on
  return {first, shape.size(), shape.data(), owner};
}

}  // namespace python
}  // namespace ferrule

NB_MODULE(_core, module) {
  using namespace ferrule;
  using namespace ferrule::python;
  module.doc() = "The C++ side of the package ferrule.";
  ::pthread_atfork(nullptr, nullptr, [] { forked = true; });
  add_error<BadInput>(module, "BadInput", PyExc_ValueError,
                      "Input that is refused: one line with place, value and the rule that it "
                      "breaks.");
  add_error<FileTrouble>(module, "FileTrouble", PyExc_OSError,
                         "A file that cannot be read or written: one line that names it and the "
                         "reason.");
  module.attr("__version__") = program_version();
  add_scene(module);
  add_simulator(module);
  add_controller(module);
  add_episode(module);
  add_learning(module);
}
