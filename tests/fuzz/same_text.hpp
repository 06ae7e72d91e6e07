#pragma once
// Results of two runs that must be the same.
#include <string>
#include <vector>

#include <tests/fuzz/findings.hpp>

namespace momentree::fuzz {

/// One line each.
std::string rendered(const std::vector<std::string>& list);

/// The same text, but for signs of zeros.
void require_same(std::string one, std::string other, const std::string& law, Findings& found);

/// The same document, in any order; with closed loops, whose equations are solved from rounded frames, the same but for rounding.
void require_same_document(const std::string& one, const std::string& other, const std::string& law, Findings& found);

}  // namespace momentree::fuzz
