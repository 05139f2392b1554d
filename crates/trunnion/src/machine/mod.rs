//! The kinematic chain: forward map, travel, singular directions.
