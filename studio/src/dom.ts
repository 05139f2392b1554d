// Elements of the page.

export function find<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

/** Tabs that show one pane at a time; arrow keys go from tab to tab. */
export class Tabs {
  private readonly tabs = [...document.querySelectorAll<HTMLElement>("[role=tab]")];

  constructor() {
    this.tabs.forEach((tab, at) => {
      tab.addEventListener("click", () => this.show(tab.getAttribute("aria-controls")!));
      tab.addEventListener("keydown", (event) => {
        const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (!by) return;
        const next = this.tabs[(at + by + this.tabs.length) % this.tabs.length]!;
        next.click();
        next.focus();
      });
    });
  }

  show(pane: string): void {
    for (const tab of this.tabs) {
      const isShown = tab.getAttribute("aria-controls") === pane;
      tab.setAttribute("aria-selected", String(isShown));
      tab.tabIndex = isShown ? 0 : -1;
      find(tab.getAttribute("aria-controls")!).hidden = !isShown;
    }
  }
}

/** Size of a file for people. */
export const sizeOf = (bytes: number): string =>
  bytes < 1e3 ? `${bytes} B` : bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(1)} GB`;
