// Layers of the scene.

/** What stands still, and what moves while a program plays. */
export const STILL = 0;
export const MOVING = 1;
/** The surface, which stands still as well, and the same in few triangles. */
export const SURFACE = 2;
export const COARSE = 3;
