// What Python packed into the page: base64 of gzip.

async function unpacked(id) {
  const packed = document.getElementById(id).textContent;
  const bytes = Uint8Array.from(atob(packed), (character) => character.charCodeAt(0));
  const text = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(text).text();
}

// The library that plots, on pages that have plots.
async function load(id) {
  if (document.getElementById(id) === null) return;
  const library = document.createElement("script");
  library.textContent = await unpacked(id);
  document.head.append(library);
}

async function show(draw) {
  const main = document.querySelector("main");
  main.setAttribute("aria-busy", "true");
  try {
    await load("plotly");
    await draw();
    document.querySelectorAll("details.drawn-too").forEach((figures) => { figures.open = false; });
  } catch (error) {
    document.body.classList.add("unscripted");
    document.getElementById("failure").hidden = false;
    throw error;
  } finally {
    main.removeAttribute("aria-busy");
  }
}
