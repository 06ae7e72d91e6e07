// C++ errors as momentree.Error.
#include <exception>
#include <new>

#include <momentree/text/diagnostic.hpp>

#include "binding.hpp"

namespace momentree::python {

namespace {

nb::object diagnostic_of(const io::Diagnostic& each) {
  return python_class("_errors", "Diagnostic")(io::word_of(each.severity), each.file, each.line, each.column, each.what,
                                               each.hint);
}

nb::list all_of(const std::vector<io::Diagnostic>& diagnostics) {
  nb::list list;
  for (const io::Diagnostic& each : diagnostics) list.append(diagnostic_of(each));
  return list;
}

void translate(const std::exception_ptr& pointer, void*) {
  try {
    std::rethrow_exception(pointer);
  } catch (const io::InputError& error) {
    const nb::object type = python_class("_errors", "Error");
    const nb::object value = type(error.problem, error.where, error.hint, error.what(), all_of(error.diagnostics));
    PyErr_SetObject(type.ptr(), value.ptr());
  } catch (const Error& error) {
    const nb::object type = python_class("_errors", "Error");
    const nb::object value = type(error.problem, error.where, error.hint);
    PyErr_SetObject(type.ptr(), value.ptr());
  } catch (const std::bad_alloc&) {
    PyErr_SetString(PyExc_MemoryError, "out of memory; a model takes about 3 kB for each body");
  }
}

}  // namespace

void register_errors(nb::module_&) { nb::register_exception_translator(translate); }

}  // namespace momentree::python
