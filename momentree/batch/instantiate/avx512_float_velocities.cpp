#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
Stepper* make_avx512_float_velocities(const Tree& tree) { return new PackVelocityStepper<Pack<float, 16, Isa::avx512>>(tree); }
}  // namespace momentree::batch
