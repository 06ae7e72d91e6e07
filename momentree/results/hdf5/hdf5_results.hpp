#pragma once
// results.h5: the tables of a run in one HDF5 file.
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/results/columns/result_columns.hpp>
#include <momentree/results/summary.hpp>

namespace momentree::io {

/// Makes results.h5 in a folder from its bodies.csv, joints.csv and, if they exist, energy.csv, springs.csv and contacts.csv:
/// groups bodies, joints, energy, springs and contacts. `world`, `joints`: for the units; those of a joint's coordinates are
/// those of its kind in `world`. Throws Error.
void write_hdf5_results(const std::filesystem::path& folder, const RunOrigin& origin, const World& world,
                        const std::vector<JointKinds>& joints, bool to_disk);

}  // namespace momentree::io
