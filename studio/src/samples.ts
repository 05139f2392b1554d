// The gallery: files that one click opens.

export interface Sample {
  name: string;
  words: string;
  files: string[];
  job: string;
  /** Program that is checked; without one the job is run. */
  program?: string;
}

export const SAMPLES: Sample[] = [
  {
    name: "Bezier patch",
    words: "Plan and check a free-form patch with a 32 mm bull-nose cutter",
    files: ["examples/bezier-patch/job.toml", "fixtures/bezier-patch/patch.json", "machines/bc-trunnion.toml"],
    job: "examples/bezier-patch/job.toml",
  },
  {
    name: "STEP face",
    words: "Plan and check a face of a STEP file",
    files: ["examples/step-face/job.toml", "examples/step-face/part.step", "machines/bc-trunnion.toml"],
    job: "examples/step-face/job.toml",
  },
  {
    name: "Impeller",
    words: "Plan and check both sides of a twisted blade, cut with the flank on five axes",
    files: ["examples/impeller/job.toml", "examples/impeller/impeller.step", "machines/bc-trunnion.toml"],
    job: "examples/impeller/job.toml",
  },
  {
    name: "Planted fault",
    words: "Check a program in which one block is too deep",
    files: [
      "examples/bezier-patch/job.toml",
      "fixtures/bezier-patch/patch.json",
      "machines/bc-trunnion.toml",
      "edited.ngc",
    ],
    job: "examples/bezier-patch/job.toml",
    program: "edited.ngc",
  },
];

/** Loads the files of a sample. */
export async function filesOf(sample: Sample): Promise<Map<string, Uint8Array<ArrayBuffer>>> {
  const load = async (name: string): Promise<[string, Uint8Array<ArrayBuffer>]> => {
    const response = await fetch(`samples/${name}`);
    if (!response.ok) throw new Error(`${name}: the server answers ${response.status}`);
    return [name, new Uint8Array(await response.arrayBuffer())];
  };
  return new Map(await Promise.all(sample.files.map(load)));
}
