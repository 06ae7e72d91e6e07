#pragma once
#include <string>
#include <vector>

#include <cli/commands.hpp>

namespace momentree::cli {

/// Like bench(), for `options.models`; `peers`: paths of the programs of other engines.
int bench_models(const BenchOptions& options, const std::vector<std::string>& peers);

}  // namespace momentree::cli
