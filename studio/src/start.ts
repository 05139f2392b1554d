// Starts the studio after the page is painted for the first time: its program takes longer to read than the page.

import "../../viewer/src/theme.css";
import "../../viewer/src/parts.css";
import "./studio.css";

requestAnimationFrame(() => setTimeout(() => void import("./main")));
