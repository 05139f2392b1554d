//! Tests of the program readers and writers: one binary, one module a subject.

mod blend_clock;
mod cl_files;
mod control_words;
mod dialect_pages;
mod fanuc;
mod gcode;
mod heidenhain;
mod linuxcnc;
mod program_flow;
#[path = "../../../trunnion-motion/tests/it/property/mod.rs"]
mod property;
mod readings;
mod shop_programs;
mod siemens;
mod siemens_cycles;
