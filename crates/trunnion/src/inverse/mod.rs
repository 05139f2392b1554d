//! Pose to axes in closed form: all branches, jets, reach.
