//! Cutters as a profile of revolution, and where they cut.
