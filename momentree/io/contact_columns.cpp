#include <momentree/io/contact_columns.hpp>

#include <momentree/io/number_text.hpp>

namespace momentree::io {

void contact_header(std::string& text) {
  text += "time,one,other";
  for (const char* what : {"point", "normal", "force"})
    for (const char* axis : {".x", ".y", ".z"}) text += std::string(",") + what + axis;
  text += ",slip\n";
}

void contact_rows(std::string& text, const World& world) {
  const auto name = [&](BodyId body) { return body == ground ? std::string("ground") : world.model()[body].name; };
  for (const ContactPoint& contact : world.contacts()) {
    append_number(text, world.time());
    text += ',' + name(contact.one) + ',' + name(contact.other);
    for (const Vec3* v : {&contact.point, &contact.normal, &contact.force})
      for (const double x : {v->x, v->y, v->z}) text += ',', append_number(text, x);
    text += ',', append_number(text, norm(contact.slip));
    text += '\n';
  }
}

}  // namespace momentree::io
