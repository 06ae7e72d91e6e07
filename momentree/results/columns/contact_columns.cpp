#include <momentree/results/columns/contact_columns.hpp>

#include <momentree/base/error.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

void contact_header(std::string& text) {
  text += "time,one,other";
  for (const char* column : contact_column_names) text += std::string(",") + column;
  text += '\n';
}

void contact_rows(std::string& text, const World& world) {
  const auto name = [&](BodyId body) { return world.model().body_name(body); };
  for (const ContactPoint& contact : world.contacts()) {
    append_number(text, world.time());
    text += ',' + name(contact.one) + ',' + name(contact.other);
    for (const Vec3* v : {&contact.point, &contact.normal, &contact.force})
      for (const double x : {v->x, v->y, v->z}) text += ',', append_number(text, x);
    text += ',', append_number(text, norm(contact.slip));
    text += '\n';
  }
}

void for_each_contact(const std::filesystem::path& file, const std::function<void(const ContactCells&)>& visit) {
  constexpr std::size_t first = 3;  // column of numbers
  std::string header;
  contact_header(header);
  header.pop_back();  // its line end
  RowReader in(file);
  if (in.columns() != split_csv(header)) throw_error({"the columns are not those of contacts", in.place(), "run again"});
  ContactCells row;
  while (in.next()) {
    const std::vector<std::string> cells = split_csv(in.line());
    if (cells.size() != in.columns().size())
      throw_error({"the row has " + std::to_string(cells.size()) + " columns", in.place(),
                   "the file was truncated or modified: run again"});
    row.time = in.time(), row.one = cells[1], row.other = cells[2];
    for (std::size_t i = 0; i < row.numbers.size(); ++i)
      row.numbers[i] = cell_number(cells[first + i], contact_column_names[i], in.place());
    visit(row);
  }
}

}  // namespace momentree::io
