//! Drives around a close obstacle toward the target by virtual forces.
