#pragma once
// Which contacts a single rule is for.
#include <momentree/tree/model.hpp>

namespace momentree {

/// True if the rule, which may be none of the model, is for contacts between two bodies of the model, or a body and the ground.
bool applies(const ContactRule& rule, const Model& model, BodyId one, BodyId other);

}  // namespace momentree
