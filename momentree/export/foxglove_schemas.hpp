#pragma once
// JSON Schemas of the messages in exported MCAP files: those of Foxglove (https://docs.foxglove.dev/docs/sdk/schemas) and of
// momentree's own topics.
#include <string>

namespace momentree::io::foxglove {

std::string frame_transforms_schema();  ///< foxglove.FrameTransforms
std::string scene_update_schema();      ///< foxglove.SceneUpdate
std::string log_schema();               ///< foxglove.Log
std::string joint_states_schema();      ///< momentree.JointStates
std::string spring_states_schema();     ///< momentree.SpringStates
std::string energy_schema();            ///< momentree.Energy

}  // namespace momentree::io::foxglove
