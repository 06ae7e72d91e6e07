#include <momentree/results/columns/spring_columns.hpp>

#include <cmath>
#include <limits>

#include <momentree/text/number_text.hpp>

namespace momentree::io {

std::array<double, 3> spring_numbers(const World& world, int spring) {
  constexpr double absent = std::numeric_limits<double>::quiet_NaN();
  const SpringView view = world.spring({spring});
  if (view.broken) return {absent, absent, absent};
  return {view.length, view.rate, view.tension};
}

void spring_header(std::string& text, const Model& model) {
  text += "time";
  for (const Spring& spring : model.springs())
    for (const char* column : spring_column_names) text += ',' + spring.name + '.' + column;
  text += '\n';
}

void spring_row(std::string& text, const World& world) {
  append_number(text, world.time());
  for (int s = 0; s < world.springs(); ++s)
    for (const double x : spring_numbers(world, s)) {
      text += ',';
      if (!std::isnan(x)) append_number(text, x);
    }
  text += '\n';
}

}  // namespace momentree::io
