//! Pictures of drives, probed at places of the world.
