// Conversion between Python values and the library's.
#include <algorithm>
#include <cmath>
#include <cstring>

#include <momentree/base/units.hpp>

#include "binding.hpp"

namespace momentree::python {

namespace {

constexpr int deepest = 32;

Value convert(nb::handle object, const std::string& what, int depth);

Value table_of(nb::handle object, const std::string& what, int depth) {
  Value::Table table;
  const nb::object items = object.attr("items")();
  for (const nb::handle item : items) {
    const nb::object key = item[0], value = item[1];
    if (!nb::isinstance<nb::str>(key)) refuse(what + ": the keys of a table are strings", "", "");
    if (value.is_none()) continue;  // absent
    std::string name = nb::cast<std::string>(key);
    table.push_back({name, Place{}, convert(value, name, depth + 1)});
  }
  return {std::move(table), Place{}};
}

Value convert(nb::handle object, const std::string& what, int depth) {
  if (depth > deepest) refuse(what + ": nested too deeply");
  if (object.is_none()) return {Value::Null{}, Place{}};
  if (nb::isinstance<nb::bool_>(object)) return {nb::cast<bool>(object), Place{}};
  if (nb::isinstance<nb::float_>(object)) return {nb::cast<double>(object), Place{}};
  if (nb::isinstance<nb::str>(object)) return {nb::cast<std::string>(object), Place{}};
  if (PyLong_Check(object.ptr())) {
    std::int64_t number = 0;
    if (nb::try_cast(object, number, false)) return {number, Place{}};
    return {nb::cast<double>(nb::float_(object)), Place{}};
  }
  if (PyObject_HasAttrString(object.ptr(), "scenario_value")) return convert(object.attr("scenario_value")(), what, depth + 1);
  if (PyObject_HasAttrString(object.ptr(), "tolist")) return convert(object.attr("tolist")(), what, depth + 1);  // NumPy
  if (PyObject_HasAttrString(object.ptr(), "items")) return table_of(object, what, depth);
  if (PyObject_HasAttrString(object.ptr(), "__fspath__")) return {nb::cast<std::string>(nb::str(object)), Place{}};
  if (PySequence_Check(object.ptr()) != 0 && !PyBytes_Check(object.ptr())) {
    Value::Array array;
    for (const nb::handle each : object) array.push_back(convert(each, what, depth + 1));
    return {std::move(array), Place{}};
  }
  if (PyObject_HasAttrString(object.ptr(), "__float__")) return {nb::cast<double>(nb::float_(object)), Place{}};
  const std::string type = nb::cast<std::string>(nb::handle(reinterpret_cast<PyObject*>(Py_TYPE(object.ptr()))).attr("__name__"));
  refuse(what + ": expected a number, a string, a list or a dictionary, found an object of type " + type);
}

nb::object numpy(const char* name) {
  static nb::object* const module = new nb::object(nb::module_::import_("numpy"));
  return module->attr(name);
}

double* memory_of(nb::handle array, std::size_t size) {
  Py_buffer view;
  if (PyObject_GetBuffer(array.ptr(), &view, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) != 0) nb::raise_python_error();
  auto* const data = static_cast<double*>(view.buf);
  const bool fits = view.len == static_cast<Py_ssize_t>(size * sizeof(double));
  PyBuffer_Release(&view);  // the array does not move
  if (!fits) refuse("NumPy made an array of another size");
  return data;
}

nb::object new_empty() { return numpy("empty"); }

std::string shape_text(nb::handle shape) {
  std::string text = "(";
  int count = 0;
  for (const nb::handle each : shape) text += (count++ > 0 ? ", " : "") + std::to_string(nb::cast<long>(each));
  return text + (count == 1 ? ",)" : ")");
}

nb::object as_array(nb::handle object, const char* what) {
  try {
    const nb::object array = numpy("asarray")(object);
    const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
    if (kind != "f" && kind != "i" && kind != "u" && kind != "b")
      refuse(std::string(what) + ": expected real numbers, found an array of dtype " +
             nb::cast<std::string>(array.attr("dtype").attr("name")));
    return numpy("ascontiguousarray")(array, "dtype"_a = "float64");
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    const std::string why = nb::cast<std::string>(nb::str(error.value()));
    refuse(std::string(what) + ": expected an array of numbers: " + why);
  }
}

void check_finite(const std::vector<double>& numbers, const char* what) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i])) refuse(std::string(what) + ": number " + std::to_string(i) + " is not finite");
}

std::vector<double> copy_numbers(const nb::object& array, const char* what, bool finite) {
  Py_buffer view;
  if (PyObject_GetBuffer(array.ptr(), &view, PyBUF_C_CONTIGUOUS) != 0) nb::raise_python_error();
  std::vector<double> numbers(static_cast<std::size_t>(view.len) / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), view.buf, numbers.size() * sizeof(double));
  PyBuffer_Release(&view);
  if (finite) check_finite(numbers, what);
  return numbers;
}

}  // namespace

Value to_value(nb::handle object, const std::string& what) { return convert(object, what, 0); }

nb::object python_class(const char* module, const char* name) {
  return nb::module_::import_((std::string("momentree.") + module).c_str()).attr(name);
}

NewArray new_array(std::size_t size) {
  static nb::object* const empty = new nb::object(new_empty());
  nb::object array = (*empty)(size);
  double* const data = memory_of(array, size);
  return {std::move(array), data};
}

NewArray new_array(std::size_t rows, std::size_t columns) {
  static nb::object* const empty = new nb::object(new_empty());
  nb::object array = (*empty)(nb::make_tuple(rows, columns));
  double* const data = memory_of(array, rows * columns);
  return {std::move(array), data};
}

nb::object copy_of(std::span<const double> numbers) {
  NewArray array = new_array(numbers.size());
  if (!numbers.empty()) std::memcpy(array.data, numbers.data(), numbers.size_bytes());
  return std::move(array.object);
}

nb::object from_vec3(const Vec3& v) {
  const double numbers[] = {v.x, v.y, v.z};
  return copy_of(numbers);
}

nb::object from_quat(const Quat& q) {
  const double numbers[] = {q.w, q.x, q.y, q.z};
  return copy_of(numbers);
}

double seconds_of(nb::handle value, const char* what) {
  double seconds = 0;
  if (nb::try_cast(value, seconds)) return seconds;
  QuantityProblem problem{"expected a time (s), found " + nb::cast<std::string>(nb::repr(value).attr("__getitem__")(
                                                              nb::slice(nb::int_(0), nb::int_(40), nb::int_(1)))),
                          example_of(dimension::time)};
  if (nb::isinstance<nb::str>(value))
    if (const auto given = parse_quantity(nb::cast<std::string>(value), dimension::time, problem)) return *given;
  refuse(problem.what, problem.hint, what);
}

Vec3 to_vec3(nb::handle object, const char* what) {
  const std::vector<double> n = numbers_of(object, 3, 0, what);
  return {n[0], n[1], n[2]};
}

namespace {

// Arrays that need no conversion are read directly: a tenth of the time.
bool read_directly(nb::handle object, std::size_t rows, std::size_t columns, std::vector<double>& numbers) {
  if (PyFloat_Check(object.ptr()) || PyList_Check(object.ptr()) || PyTuple_Check(object.ptr())) return false;
  Py_buffer view;
  if (PyObject_GetBuffer(object.ptr(), &view, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS) != 0) {
    PyErr_Clear();
    return false;
  }
  const bool fits = view.format != nullptr && view.format[0] == 'd' && view.format[1] == 0 &&
                    view.ndim == (columns == 0 ? 1 : 2) && view.shape[0] == static_cast<Py_ssize_t>(rows) &&
                    (columns == 0 || view.shape[1] == static_cast<Py_ssize_t>(columns));
  if (fits) {
    const auto* const first = static_cast<const double*>(view.buf);
    numbers.assign(first, first + rows * std::max<std::size_t>(columns, 1));
  }
  PyBuffer_Release(&view);
  return fits;
}

}  // namespace

std::vector<double> numbers_of(nb::handle object, std::size_t rows, std::size_t columns, const char* what, bool finite) {
  if (std::vector<double> numbers; read_directly(object, rows, columns, numbers)) {
    if (finite) check_finite(numbers, what);
    return numbers;
  }
  const nb::object array = as_array(object, what);
  const nb::tuple shape(array.attr("shape"));
  const std::size_t dimensions = columns == 0 ? 1 : 2;
  const bool fits = shape.size() == dimensions && nb::cast<std::size_t>(shape[0]) == rows &&
                    (columns == 0 || nb::cast<std::size_t>(shape[1]) == columns);
  if (!fits)
    refuse(std::string(what) + ": expected an array of shape (" + std::to_string(rows) +
           (columns == 0 ? "," : ", " + std::to_string(columns)) + "), found one of shape " + shape_text(shape));
  return copy_numbers(array, what, finite);
}

std::vector<double> rows_of(nb::handle object, std::size_t rows, std::size_t columns, const char* what) {
  if (columns > 0) return numbers_of(object, rows, columns, what);
  const nb::tuple shape(as_array(object, what).attr("shape"));
  if (shape.size() != 2 || nb::cast<std::size_t>(shape[0]) != rows || nb::cast<std::size_t>(shape[1]) != 0)
    refuse(std::string(what) + ": expected an array of shape (" + std::to_string(rows) + ", 0), found one of shape " +
           shape_text(shape));
  return {};
}

std::vector<double> numbers_of(nb::handle object, const char* what) {
  const nb::object array = numpy("atleast_1d")(as_array(object, what));
  const nb::tuple shape(array.attr("shape"));
  if (shape.size() != 1) refuse(std::string(what) + ": expected one dimension, found an array of shape " + shape_text(shape));
  return copy_numbers(array, what, true);
}

}  // namespace momentree::python
