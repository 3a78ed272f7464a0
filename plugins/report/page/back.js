// A page that another links to leads back to it.
const from = new URLSearchParams(location.search).get("from") ?? "";
if (/^\.\.\/[\w./-]+\.html$/.test(from)) {
  const back = document.getElementById("back");
  back.href = from;
  back.closest("[hidden]").hidden = false;
}
