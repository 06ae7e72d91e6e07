#pragma once

namespace momentree {

/// How a joint is used, which selects its kernels: as declared, with armature, with locked DoFs, with parent and child exchanged,
/// or exchanged and locked.
enum class Variant : unsigned char { plain, armature, locked, reversed, reversed_locked };

}  // namespace momentree
