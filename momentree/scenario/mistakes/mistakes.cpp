#include <momentree/scenario/mistakes/mistakes.hpp>

#include <unordered_map>

#include <momentree/base/edit_distance.hpp>
#include <momentree/scenario/mistakes/keys.hpp>

namespace momentree::io {

namespace {

// Iterates over the parts of a text between separators.
class Parts {
 public:
  Parts(std::string_view text, char separator) : rest_(text), separator_(separator) {}
  bool next(std::string_view& part) {
    if (done_) return false;
    const std::size_t end = rest_.find(separator_);
    part = rest_.substr(0, end);
    done_ = end == std::string_view::npos;
    if (!done_) rest_.remove_prefix(end + 1);
    return true;
  }

 private:
  std::string_view rest_;
  char separator_;
  bool done_ = false;
};

bool is_one_of(std::string_view word, std::string_view words, char separator) {
  Parts parts(words, separator);
  for (std::string_view part; parts.next(part);)
    if (part == word) return true;
  return false;
}

using Index = std::unordered_map<std::string_view, std::vector<const Mistake*>>;

const Index& by_word() {
  static const Index index = [] {
    Index made;
    for (const Mistake* mistake : all_mistakes()) {
      Parts words(mistake->words, ' ');
      for (std::string_view word; words.next(word);) made[word].push_back(mistake);
    }
    return made;
  }();
  return index;
}

}  // namespace

std::vector<const Mistake*> all_mistakes() {
  std::vector<const Mistake*> all;
  for (const auto table : {mistakes::of_runs(), mistakes::of_models(), mistakes::of_events()})
    for (const Mistake& each : table) all.push_back(&each);
  return all;
}

std::vector<const Mistake*> mistakes_of(std::string_view where, std::string_view word) {
  std::vector<const Mistake*> found;
  if (word.size() > 40) return found;
  const auto known = by_word().find(plain_word(word));
  if (known == by_word().end()) return found;
  for (const bool here : {true, false})  // those of this table before those of any table
    for (const Mistake* each : known->second)
      if (here == (*each->where != '\0') && (!here || is_one_of(where, each->where, '|'))) found.push_back(each);
  return found;
}

std::string cure_of(const Mistake& mistake) {
  if (*mistake.key == '\0') return mistake.text;
  return "write '" + std::string(mistake.key) + "', as in " + mistake.text;
}

}  // namespace momentree::io
