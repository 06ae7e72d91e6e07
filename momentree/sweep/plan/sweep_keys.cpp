#include <momentree/sweep/plan/sweep_keys.hpp>

#include <momentree/scenario/keys/schema_parts.hpp>

namespace momentree::sweep {

namespace {

using io::Key;
using namespace io::type;

// A number, a string with a unit, or a list of them for a vector.
#define MOMENTREE_NUMBER R"({"type": ["number", "string"]})"
#define MOMENTREE_NUMBERS R"({"anyOf": [)" MOMENTREE_NUMBER R"(, {"type": "array", "items": )" MOMENTREE_NUMBER R"(}]})"
#define MOMENTREE_ARGUMENTS(count) \
  R"({"type": "array", "items": )" MOMENTREE_NUMBERS R"(, "minItems": )" #count R"(, "maxItems": )" #count "}"
constexpr io::Type two = other(MOMENTREE_ARGUMENTS(2)), three = other(MOMENTREE_ARGUMENTS(3)), numbers = other(MOMENTREE_NUMBERS);

constexpr Key vary_keys[] = {
    {"list", other(R"({"type": "array", "minItems": 1})"), "The values, of any type"},
    {"weights", other(R"({"type": "array", "items": {"type": "number", "minimum": 0}})"), "With list: how likely each value is"},
    {"range", other(R"({"type": "array", "minItems": 3, "maxItems": 3})"), "From, to and count: evenly spaced, ends included"},
    {"uniform", two, "From and to"},
    {"normal", two, "Mean and standard deviation"},
    {"lognormal", two, "Mean and standard deviation of the natural logarithm of the value"},
    {"exponential", numbers, "Mean"},
    {"weibull", two, "Scale and shape"},
    {"triangular", three, "Least, most likely and greatest value"},
    {"beta", two, "The two shapes; `within` gives the interval, default 0 to 1"},
    {"latin", two, "From and to: uniform, as a Latin hypercube"},
    {"sobol", two, "From and to: uniform, as a Sobol sequence"},
    {"within", two, "Bounds of a normal or beta distribution"},
    {"sampling", choice("random|latin|sobol"), "How the distribution is sampled", R"("random")"},
};

constexpr Key correlated_keys[] = {
    {"parameters", other(R"({"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2})"),
     "Two keys of [vary]; \".0\", \".1\" … after the key of a vector selects a component", nullptr, "name two keys of [vary]"},
    {"coefficient", number(dimension::number), "Correlation of the underlying normal variables, between -1 and 1", nullptr,
     "for example 0.8"},
};

constexpr const char* source_schema = R"({"anyOf": [{"type": "string"}, {"type": "object"}]})";
constexpr Key measure_keys[] = {
    {"happened", string, "The name of an event: whether it happened"},
    {"time_of", string, "The name of an event: its time (s); empty if it did not happen"},
    {"count", string, "The name of an event: how often it happened"},
    {"event", string, "The name of an event, of which `value` is recorded"},
    {"value", string, "With event: a number of its certificate; with max and min: \"time\" for the time of the extreme"},
    {"number", other(R"({"type": "integer"})"), "With event and time_of: which of several; -1 is the last", "1"},
    {"max", other(source_schema), "The largest value of a quantity or column during the run"},
    {"min", other(source_schema), "The smallest value of a quantity or column during the run"},
    {"mean", other(source_schema), "The mean of a quantity or column over time"},
    {"final", other(source_schema), "A quantity or column at the end of the run"},
    {"column", other(source_schema), "A quantity or column at the instant `at`"},
    {"at", number(dimension::time, Range::not_negative), "With column: the instant"},
};

constexpr Key stop_keys[] = {
    {"after", other(R"({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]})"),
     "A world ends after this event, or one of these"},
    {"steps", other(R"({"type": "integer", "minimum": 1})"), "A world that needs more steps fails"},
};

constexpr Key output_keys[] = {
    {"file", string, "A folder, or a file that ends in .h5; default: results/ and the sweep's name"},
    {"json_lines", boolean, "Also write worlds.jsonl", "false"},
};

constexpr Key sweep_keys[] = {
    {"format", other(R"({"const": 1})"), "Version of the format"},
    {"title", string, "Title, shown with the results"},
    {"scenario", string, "The scenario or model file, relative to this file", nullptr, "scenario = \"capture.toml\""},
    {"worlds", other(R"({"type": "integer", "minimum": 1})"),
     "How many worlds; default: every combination of the lists and ranges"},
    {"seed", other(R"({"type": "integer", "minimum": 0})"), "Seed of all random values", "0"},
    {"vary",
     other(R"({"type": "object", "minProperties": 1, "additionalProperties": {"anyOf": [{"type": "array", "minItems": 1}, @]}})",
           vary_table),
     "What is varied, by dotted paths as in --set: a list, or how to draw values", nullptr,
     "add a [vary] table, as in \"event.grasp.when.below\" = { uniform = [0.2, 0.4] }"},
    {"correlated", tables(correlated_table), "Varied values that are not independent"},
    {"measure", other(R"({"type": "object", "minProperties": 1, "additionalProperties": @})", measure_table),
     "What is recorded of each world, by names", nullptr, "add a [measure] table, as in x = { final = \"tug/gripper.x\" }"},
    {"stop", table(stop_table), "When a world ends before its scenario does"},
    {"output", table(output_table), "Output"},
};

}  // namespace

constinit const io::KeyTable vary_table{
    "[vary]",
    "vary",
    "How a value is varied",
    vary_keys,
    {{io::KeyRule::How::one, "list range uniform normal lognormal exponential weibull triangular beta latin sobol"}}};
constinit const io::KeyTable correlated_table{"[[correlated]]", "correlated", "Two varied values that are not independent",
                                              correlated_keys};
constinit const io::KeyTable measure_table{"[measure]",
                                           "measure",
                                           "What is recorded of each world",
                                           measure_keys,
                                           {{io::KeyRule::How::one, "happened time_of count event max min mean final column"}}};
constinit const io::KeyTable stop_table{"[stop]", "", "When a world ends before its scenario does", stop_keys};
constinit const io::KeyTable output_table{"[output]", "", "Output", output_keys};
constinit const io::KeyTable sweep_table{"a sweep", "", "A sweep: many worlds of one scenario", sweep_keys};

std::string sweep_schema() { return io::schema::document("momentree sweep", sweep_table); }

}  // namespace momentree::sweep
