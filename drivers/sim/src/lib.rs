//! A simulated Pioneer.
