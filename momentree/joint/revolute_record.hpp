#pragma once
// Quantities of a revolute body that the inward pass stores for the outward pass, and for further right-hand sides.
#include <momentree/joint/body_pair.hpp>
#include <momentree/joint/link_constants.hpp>

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

MOMENTREE_INLINE void part(const RevoluteRecord<BodyPair>& from, RevoluteRecord<double>& one, RevoluteRecord<double>& other) {
  part(from.A, one.A, other.A), part(from.l, one.l, other.l), part(from.gl, one.gl, other.gl), part(from.mc, one.mc, other.mc);
  part(from.Bxx, one.Bxx, other.Bxx), part(from.Bxy, one.Bxy, other.Bxy), part(from.Byx, one.Byx, other.Byx);
  part(from.Byy, one.Byy, other.Byy), part(from.Bzx, one.Bzx, other.Bzx), part(from.Bzy, one.Bzy, other.Bzy);
  part(from.Jxx, one.Jxx, other.Jxx), part(from.Jxy, one.Jxy, other.Jxy), part(from.Jyy, one.Jyy, other.Jyy);
  part(from.hx, one.hx, other.hx), part(from.hy, one.hy, other.hy), part(from.ghx, one.ghx, other.ghx);
  part(from.ghy, one.ghy, other.ghy), part(from.u0, one.u0, other.u0);
  part(from.inverse_mass, one.inverse_mass, other.inverse_mass);
}
MOMENTREE_INLINE void part(const ArmatureRecord<BodyPair>& from, ArmatureRecord<double>& one, ArmatureRecord<double>& other) {
  part(static_cast<const RevoluteRecord<BodyPair>&>(from), static_cast<RevoluteRecord<double>&>(one),
       static_cast<RevoluteRecord<double>&>(other));
  part(from.armature, one.armature, other.armature), part(from.hz, one.hz, other.hz), part(from.ghz, one.ghz, other.ghz);
}

}  // namespace momentree
