//! APT/CL and G-code: words, reading, writing.
