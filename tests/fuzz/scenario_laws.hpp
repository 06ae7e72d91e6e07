#pragma once
// Laws that must hold for every scenario and its runs.
#include <string>

#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/findings.hpp>
#include <tests/fuzz/traced_run.hpp>

namespace momentree::fuzz {

/// Reads the text, runs it in many ways, and checks the laws for the results. `choose` decides where runs are stopped.
/// `continued`: also restarts from documents.
void check_scenario(const std::string& text, Choices& choose, Findings& found, bool continued = true);
/// The same for a file, of which at most `steps` steps are run: without restarts from documents, conversion and other methods.
void check_file(const std::string& path, long steps, Choices& choose, Findings& found);

}  // namespace momentree::fuzz
