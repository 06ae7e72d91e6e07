#pragma once
// Which contacts a single rule is for.
#include <momentree/model/model.hpp>

namespace momentree {

/// True if the rule is for contacts between two bodies, or a body and the ground.
bool applies(const ContactRule& rule, BodyId one, BodyId other);

}  // namespace momentree
