// The elements of the page.

export function the<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

export const input = (id: string): HTMLInputElement => the<HTMLInputElement>(id);
export const select = (id: string): HTMLSelectElement => the<HTMLSelectElement>(id);
export const button = (id: string): HTMLButtonElement => the<HTMLButtonElement>(id);

export function offer(list: HTMLSelectElement, values: Iterable<string>): void {
  for (const value of values) list.add(new Option(value, value));
}

export function show(id: string, visible: boolean): void {
  the(id).hidden = !visible;
}

/** Says what is wrong, or nothing. */
export function say(message: string): void {
  the("message").textContent = message;
  show("message", message !== "");
}
