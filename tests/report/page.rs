//! The page in a real browser.

use std::io::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::browser::{Browser, installed};
use super::with;

/// Contrast of every piece of text against what is behind it, where it is below 4.5 (WCAG 2, AA; large text asks for 3).
const FAINT: &str = r#"(() => {
  const parse = (color) => (color.match(/[\d.]+/g) ?? []).map(Number);
  const channel = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const behind = (node) => {
    for (let at = node; at; at = at.parentElement) {
      const color = parse(getComputedStyle(at).backgroundColor);
      if (color.length === 3 || color[3] > 0) return color;
    }
    return [255, 255, 255];
  };
  const faint = [];
  for (const node of document.body.querySelectorAll("*")) {
    if (node.closest("svg, script, style")) continue;
    const own = [...node.childNodes].some((child) => child.nodeType === 3 && child.data.trim());
    if (!own) continue;
    const style = getComputedStyle(node);
    const [a, b] = [light(parse(style.color)), light(behind(node))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
    if (ratio < (large ? 3 : 4.5)) faint.push(`${ratio.toFixed(2)}: ${node.textContent.slice(0, 40)}`);
  }
  return faint;
})()"#;

/// The width that the content takes beyond the window.
const OVERHANG: &str =
    "document.documentElement.scrollWidth - document.documentElement.clientWidth";

const SHOWN: &str = "[...document.querySelectorAll('.claims tbody tr')].filter((row) => row.getClientRects().length > 0).length";

fn count(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(program) = installed() else {
        // Past the capture of what tests print: nobody sees that of one that passes.
        let _ = writeln!(
            std::io::stderr(),
            "skipped: no Chromium is installed; the report's page was not looked at"
        );
        return;
    };
    with(|report| {
        let page = report.folder.path().join("report/index.html");
        let mut browser = Browser::open(&program, &page);
        for scheme in ["light", "dark"] {
            for width in [1280, 375] {
                browser.look(width, scheme);
                browser.navigate(&page);
                let what = format!("{scheme}, {width} px");
                assert_eq!(browser.evaluate(OVERHANG), json!(0), "{what}");
                assert_eq!(browser.evaluate(FAINT), json!([]), "{what}");
                // Open what is folded: it must fit, too.
                browser.evaluate(
                    "document.querySelectorAll('details').forEach((one) => (one.open = true))",
                );
                assert_eq!(browser.evaluate(OVERHANG), json!(0), "{what}, unfolded");
            }
        }
        browser.look(1280, "light");
        browser.navigate(&page);
        nothing_is_folded_on_paper(&mut browser);
        every_figure_shows(&mut browser);
        the_filter_works(&mut browser, report.ledger.counts().map(|(_, count)| count));
        columns_sort(&mut browser);
        links_lead_somewhere(&mut browser, &page);
        assert_eq!(browser.complaints, Vec::<String>::new());
    });
}

fn nothing_is_folded_on_paper(browser: &mut Browser) {
    let folded = "[...document.querySelectorAll('details li, details td')].filter((one) => !one.checkVisibility()).length";
    assert_ne!(count(&browser.evaluate(folded)), 0);
    browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    assert_eq!(count(&browser.evaluate(folded)), 0);
    browser.look(1280, "light");
}

fn every_figure_shows(browser: &mut Browser) {
    let sizes = browser.evaluate(
        "[...document.querySelectorAll('figure svg')].map((svg) => { const box = svg.getBoundingClientRect(); \
         return [box.width, box.height, svg.querySelectorAll('path, text, polyline, circle').length, \
         svg.querySelector('title').textContent.length, svg.querySelector('desc').textContent.length]; })",
    );
    let sizes = sizes.as_array().unwrap();
    // Seven of the paper, the convergence and the scan.
    assert_eq!(sizes.len(), 9);
    for of_one in sizes {
        let [width, height, shapes, title, description] = &of_one.as_array().unwrap()[..] else {
            panic!("{of_one}");
        };
        assert!(
            width.as_f64().unwrap() > 600.0 && height.as_f64().unwrap() > 200.0,
            "{of_one}"
        );
        assert!(
            count(shapes) > 30 && count(title) > 10 && count(description) > 100,
            "{of_one}"
        );
    }
}

/// By keyboard: the first button has the focus, arrows go on to the next.
fn the_filter_works(browser: &mut Browser, counts: [usize; 4]) {
    let all: usize = counts.iter().sum();
    assert_eq!(count(&browser.evaluate(SHOWN)), all);
    browser.evaluate("document.getElementById('all').focus()");
    for wanted in counts {
        browser.press("ArrowRight", 39);
        assert_eq!(count(&browser.evaluate(SHOWN)), wanted);
        let own = browser.evaluate(
            "new Set([...document.querySelectorAll('.claims tbody tr')].filter((row) => row.getClientRects().length > 0).map((row) => row.className)).size",
        );
        assert_eq!(count(&own), usize::from(wanted > 0));
    }
    browser.press("ArrowRight", 39);
    assert_eq!(count(&browser.evaluate(SHOWN)), all);
}

fn columns_sort(browser: &mut Browser) {
    let order = "[...document.querySelectorAll('.claims tbody tr')].map((row) => row.cells[3].dataset.key).join('')";
    let before = browser.evaluate(order);
    let click = "document.querySelectorAll('.claims thead button')[3].click()";
    browser.evaluate(click);
    let sorted = browser.evaluate(order);
    let text = sorted.as_str().unwrap();
    assert!(text.chars().is_sorted() && sorted != before, "{text}");
    browser.evaluate(click);
    assert!(
        browser
            .evaluate(order)
            .as_str()
            .unwrap()
            .chars()
            .rev()
            .is_sorted()
    );
    browser.evaluate(click);
    assert_eq!(browser.evaluate(order), before);
}

/// Links within the page have a target; those to files lead into the project, where the page lies.
fn links_lead_somewhere(browser: &mut Browser, page: &Path) {
    let dangling = browser.evaluate(
        "[...document.querySelectorAll('a[href^=\"#\"]')].filter((a) => !document.getElementById(a.hash.slice(1))).map((a) => a.hash)",
    );
    assert_eq!(dangling, json!([]), "{}", page.display());
    let files = browser.evaluate(
        "[...document.querySelectorAll('a[href^=\"../\"]')].map((a) => a.getAttribute('href').slice(3))",
    );
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = files.as_array().unwrap();
    assert!(files.len() > 10);
    for file in files {
        let file = top.join(file.as_str().unwrap());
        assert!(file.exists(), "{} is linked and missing", file.display());
    }
}
