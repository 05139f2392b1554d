//! Tests of the whole engine: one binary, one module a subject.

mod around;
mod audit;
mod audited;
mod axes;
mod barrels;
mod blocks;
mod bounds;
mod brute_force;
#[path = "../../../trunnion-motion/tests/it/chains/mod.rs"]
mod chains;
mod clamps;
mod conserved;
mod contour;
mod control_state;
mod control_times;
mod cover;
#[path = "../../../trunnion-motion/tests/it/dice/mod.rs"]
mod dice;
mod dog_legs;
#[path = "../../../trunnion-motion/tests/it/every_choice/mod.rs"]
mod every_choice;
mod extended;
mod failures;
mod files;
mod fixtures;
mod grazes;
mod growth;
mod hops;
mod imports;
mod inner_velocities;
mod kinematics;
mod layers;
mod links;
mod machine_files;
mod many_poses;
mod methods;
mod names;
mod nc;
mod operations;
mod paper_002;
mod planted;
mod positioning;
mod positioning_bounds;
mod positioning_threads;
mod post;
mod post_feeds;
mod posted;
#[path = "../../../trunnion-motion/tests/it/property/mod.rs"]
mod property;
mod random_cut;
mod random_motion;
mod random_programs;
mod rest;
mod rooms;
mod round_trip;
mod run_dialects;
mod setpoints;
mod shop;
mod short_moves;
mod smoothed_posts;
mod smoothing;
mod smoothing_bounds;
mod sources;
mod step_solids;
mod stock;
mod swept_tool;
mod tables;
mod tilted;
mod tip_feeds;
mod toolpath;
mod unwinding;
mod validator;
mod vectors;
mod verify;
#[path = "../../../trunnion-motion/tests/it/waves/mod.rs"]
mod waves;
