#pragma once
// Shared by the parts of the extension: registration functions, conversion of values, errors.
#include <nanobind/nanobind.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <span>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/base/value.hpp>
#include <momentree/math/values.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::python {

namespace nb = nanobind;
using namespace nb::literals;

void register_errors(nb::module_& m);
void register_model(nb::module_& m);
class SimulationObject;
using SimulationClass = nb::class_<SimulationObject>;
void register_simulation(nb::module_& m);
void register_equations(SimulationClass& simulation);
void register_events(nb::module_& m, SimulationClass& simulation);
void register_history(nb::module_& m, SimulationClass& simulation);
void register_world(nb::module_& m);
void register_vocabulary(nb::module_& m);
void register_batch(nb::module_& m);
void register_sweep(nb::module_& m);
void register_live(nb::module_& m);

/// The Python class of that name in the package's module `momentree.<module>`, imported once.
nb::object python_class(const char* module, const char* name);

/// A Python value as the tree that scenario readers read: None, bool, int, float, str, mappings, sequences, NumPy scalars and
/// arrays. Throws Error for anything else; `what` names it.
Value to_value(nb::handle object, const std::string& what);
nb::object from_vec3(const Vec3& v);
nb::object from_quat(const Quat& q);
/// Three finite numbers.
Vec3 to_vec3(nb::handle object, const char* what);

/// A time in seconds: a number, or a string with a unit. Throws Error for anything else; `what` names it.
double seconds_of(nb::handle value, const char* what);

/// A new NumPy array of doubles: the object and its memory, which is not initialised.
struct NewArray {
  nb::object object;
  double* data = nullptr;
};
NewArray new_array(std::size_t size);
NewArray new_array(std::size_t rows, std::size_t columns);
nb::object copy_of(std::span<const double> numbers);

/// The numbers of an array-like of that shape (columns 0: one dimension of `rows` numbers), converted to double. Throws Error for
/// another shape, for values that are no real numbers, and, if `finite`, for infinities and NaN.
std::vector<double> numbers_of(nb::handle object, std::size_t rows, std::size_t columns, const char* what, bool finite = true);
/// The same in two dimensions, also without columns.
std::vector<double> rows_of(nb::handle object, std::size_t rows, std::size_t columns, const char* what);
/// The same, one-dimensional and of any length.
std::vector<double> numbers_of(nb::handle object, const char* what);

/// An Error without a place.
[[noreturn]] inline void refuse(std::string problem, std::string hint = {}, std::string where = {}) {
  throw Error(std::move(problem), std::move(where), std::move(hint));
}

}  // namespace momentree::python
