// What the parts of the Python module share. Docstrings are the specification of the package: units
// [..], shapes, what is raised.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "controller/observation.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule::python {

namespace nb = nanobind;
using Array = nb::ndarray<nb::numpy, double>;
using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

// How a property returns an array: it has an owner, and is not copied.
inline constexpr auto kOwned = nb::rv_policy::reference;

void add_scene(nb::module_& module);
void add_simulator(nb::module_& module);
void add_controller(nb::module_& module);
void add_episode(nb::module_& module);

// `count` numbers of any sequence or array; ValueError "WHAT: ..." where it is something else.
Eigen::VectorXd numbers(nb::handle from, Eigen::Index count, const char* what);
// A new array.
Array array(const double* values, std::vector<std::size_t> shape);
template <class Vector>
Array array(const Vector& values) {
  return array(values.data(), {static_cast<std::size_t>(values.size())});
}

// In a process that was forked the threads are gone: everything runs on one thread there.
int threads_here(int threads) noexcept;

}  // namespace ferrule::python
