// What scrolls can be scrolled with the keyboard, too: code and tables that are wider than the page.
const scrolled = new ResizeObserver((entries) => {
  for (const { target } of entries)
    if (target.scrollWidth > target.clientWidth) target.tabIndex = 0;
    else target.removeAttribute("tabindex");
});
for (const each of document.querySelectorAll("div.highlight pre, .table-wrapper")) scrolled.observe(each);
