// The tables of elements between bodies or joints, and the readers of the kinds that have tables of their own.
#include <array>

#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

class ElementReader : public FieldReader {
 public:
  ElementReader(Fields& fields, Reading& reading) : FieldReader(fields), reading_(reading) {}
  using FieldReader::operator();
  void operator()(const char* key, JointId& joint, const Field&) {
    const Value* const name = fields_.require(key);
    if (name != nullptr) joint = coupled_joint(*name, key, true, reading_);
    complete_ = complete_ && joint.index >= 0;
    if (joint.index < 0 || known_++ > 0) return;
    along_ = info(reading_.scenario.model[joint].joint.kind).q_units[0] == 'm';
  }
  void operator()(const char* key, double& x, const Field& field) {
    if (field.required != nullptr) fields_.require(key);
    if (field.of_joint && !complete_) return static_cast<void>(fields_.find(key));  // its unit is not known
    x = (field.of_joint ? fields_.number(key, along_ ? field.along : field.dimension) : fields_.number(key)).value_or(x);
  }
  /// False if a joint is missing, wrong, or of a mechanism with errors.
  bool complete() const { return complete_; }

 private:
  Reading& reading_;
  bool along_ = false, complete_ = true;
  int known_ = 0;
};

template <class Kind>
constinit const KeyTable keys_of_kind{.name = Kind::info.table,
                                      .definition = Kind::info.key,
                                      .about = Kind::info.about,
                                      .described = &keys_of<Kind>,
                                      .details = Kind::info.details};

template <class Kind>
void read(const Value& table, Reading& reading) {
  const std::size_t errors = reading.out.errors();
  Fields fields(table, keys_of_kind<Kind>, reading.out);
  ElementReader reader(fields, reading);
  Kind kind;
  describe(reader, kind);
  fields.finish();
  if (!reader.complete() || errors != reading.out.errors()) return;
  Model& model = reading.scenario.model;
  for (const ElementProblem& problem : check_element(kind, model))
    reading.out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, problem.hint);
  if (errors != reading.out.errors()) return;
  model.add_element(std::move(kind));
  reading.element_places.push_back(fields.place());
}

template <class... Kinds>
auto list_tables(const std::variant<std::monostate, Kinds...>*) {
  std::array<ElementTable, 3 + (std::size_t{has_table<Kinds>} + ... + 0)> all{ElementTable{&spring_table, read_spring},
                                                                              {&cable_table, read_cable}};
  std::size_t next = 2;
  const auto add = [&]<class Kind>(const Kind*) {
    if constexpr (has_table<Kind>) all[next++] = {&keys_of_kind<Kind>, read<Kind>};
  };
  (add(static_cast<const Kinds*>(nullptr)), ...);
  all[next] = {&coupling_table, read_coupling};
  return all;
}

}  // namespace

std::span<const ElementTable> element_tables() {
  static const auto all = list_tables(static_cast<const JointElement*>(nullptr));
  return all;
}

}  // namespace momentree::io
