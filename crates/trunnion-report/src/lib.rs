//! Results of trunnion as one self-contained HTML file.
