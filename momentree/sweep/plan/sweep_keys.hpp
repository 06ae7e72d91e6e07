#pragma once
// The tables of sweep files, for their readers and for the schema.
#include <string>

#include <momentree/scenario/keys/keys.hpp>

namespace momentree::sweep {

/// `sweep_table` is the whole file.
extern const io::KeyTable sweep_table, vary_table, correlated_table, measure_table, stop_table, output_table;

/// The JSON Schema of sweep files, as text.
std::string sweep_schema();

}  // namespace momentree::sweep
