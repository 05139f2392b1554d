//! The command line: read, call the library, write.

fn main() {}
