#pragma once
// Quantities of a revolute body that the inward pass stores for the outward pass, and for further right-hand sides.
#include <momentree/math/spatial.hpp>

namespace momentree {

/// After reduction about z: M̂ E = 0, so B has no z column and J no z row; D̂·E = p; G·E = 1.
template <class T>
struct RevoluteRecord {
  Symmetric3<T> A;
  T Bxx, Bxy, Byx, Byy, Bzx, Bzy, Jxx, Jxy, Jyy;
  Vector3<T> l;  // D̂
  T hx, hy;
  Vector3<T> gl;  // G
  T ghx, ghy;
  T u0, inverse_mass;
  Vector3<T> mc;
};
/// With armature these are not zero: M̂ E = armature · G, D̂·E, G·E. The armature may be arbitrarily large, since `damped` turns
/// dampers into armature; so u is not computed from u + ω_z, nor D̂·E from p less the armature's momentum, where digits would
/// cancel.
template <class T>
struct ArmatureRecord : RevoluteRecord<T> {
  T armature, hz, ghz;
};

}  // namespace momentree
