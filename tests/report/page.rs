//! The page in a real browser.

use std::io::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::browser::{Browser, installed};
use super::with;

/// Lists every piece of text whose contrast with its background is below 4.5 (WCAG 2, AA; large
/// text requires 3).
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
    if (ratio < (large ? 3 : 4.5))
      faint.push(`${ratio.toFixed(2)}: ${node.textContent.slice(0, 40)}`);
  }
  return faint;
})()"#;

/// The width of the content beyond the window.
const OVERHANG: &str =
    "document.documentElement.scrollWidth - document.documentElement.clientWidth";

const SHOWN: &str = "[...document.querySelectorAll('.claims .sortable tbody tr')].filter((row) => \
    row.getClientRects().length > 0).length";

fn count(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(program) = installed() else {
        // Bypasses the capture of test output, which is not shown for tests that pass.
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
                // Opens what is folded: it must fit, too.
                browser.evaluate(
                    "document.querySelectorAll('details').forEach((one) => (one.open = true))",
                );
                assert_eq!(browser.evaluate(OVERHANG), json!(0), "{what}, unfolded");
            }
        }
        browser.look(1280, "light");
        browser.navigate(&page);
        paper_folds_as_the_reader_does(&mut browser);
        verdicts_are_whole_words(&mut browser);
        narrow_figures_say_that_they_scroll(&mut browser);
        every_figure_shows(&mut browser);
        let mut counts = report.ledger.counts().map(|(_, count)| count).to_vec();
        counts.push(report.ledger.entries.len() - report.ledger.counted());
        the_filter_works(&mut browser, &counts);
        columns_sort(&mut browser);
        links_lead_somewhere(&mut browser, &page);
        assert_eq!(browser.complaints, Vec::<String>::new());
    });
}

/// What is folded stays folded in print; what the reader opened is printed.
fn paper_folds_as_the_reader_does(browser: &mut Browser) {
    let folded = "[...document.querySelectorAll('details li, details td')].filter((one) => \
        !one.checkVisibility()).length";
    let on_screen = count(&browser.evaluate(folded));
    assert_ne!(on_screen, 0);
    browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    assert_eq!(count(&browser.evaluate(folded)), on_screen);
    browser.evaluate("document.querySelectorAll('details').forEach((one) => (one.open = true))");
    assert_eq!(count(&browser.evaluate(folded)), 0);
    browser.evaluate("document.querySelectorAll('details').forEach((one) => (one.open = false))");
    let printed = browser.call("Page.printToPDF", json!({ "preferCSSPageSize": true }));
    let pages = pages(printed["data"].as_str().unwrap());
    assert!((5..=14).contains(&pages), "{pages} pages");
    browser.look(1280, "light");
}

/// Number of pages of a PDF in base 64, whose page objects are not compressed.
fn pages(base64: &str) -> usize {
    let mut bytes = Vec::new();
    let (mut bits, mut held) = (0_u32, 0);
    for c in base64.bytes() {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => break,
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held & 0xff) as u8);
        }
    }
    let text = String::from_utf8_lossy(&bytes);
    text.matches("/Type /Page").count() - text.matches("/Type /Pages").count()
}

/// No word of a verdict is broken, at any width or on paper. The text of a mark has at most as many
/// lines as words.
fn verdicts_are_whole_words(browser: &mut Browser) {
    let broken = "[...document.querySelectorAll('.mark')].filter((mark) => { const range = \
        document.createRange(); range.selectNodeContents(mark); const tops = \
        [...range.getClientRects()].map((box) => Math.round(box.top)); return new Set(tops).size > \
        mark.textContent.trim().split(/\\s+/).length || (mark.closest('td') && \
        mark.getBoundingClientRect().right > mark.closest('td').getBoundingClientRect().right + \
        1); }).map((mark) => mark.textContent)";
    for width in [1280, 700, 375] {
        browser.look(width, "light");
        assert_eq!(browser.evaluate(broken), json!([]), "{width} px");
    }
    // The width of a printed page between its margins.
    browser.look(700, "light");
    browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    assert_eq!(browser.evaluate(broken), json!([]), "paper");
    browser.look(1280, "light");
}

/// On a narrow screen a figure is wider than its frame, and a note above says that it scrolls.
fn narrow_figures_say_that_they_scroll(browser: &mut Browser) {
    let reported = "[...document.querySelectorAll('figure')].map((one) => \
        [one.firstElementChild.scrollWidth > one.clientWidth, getComputedStyle(one, \
        '::before').content.includes('scroll')])";
    browser.look(375, "light");
    for one in browser.evaluate(reported).as_array().unwrap() {
        assert_eq!(*one, json!([true, true]));
    }
    browser.look(1280, "light");
    for one in browser.evaluate(reported).as_array().unwrap() {
        assert_eq!(*one, json!([false, false]));
    }
}

fn every_figure_shows(browser: &mut Browser) {
    let sizes = browser.evaluate(
        "[...document.querySelectorAll('figure svg')].map((svg) => { const box = \
         svg.getBoundingClientRect(); return [box.width, box.height, svg.querySelectorAll('path, \
         text, polyline, circle').length, svg.querySelector('title').textContent.length, \
         svg.querySelector('desc').textContent.length]; })",
    );
    let sizes = sizes.as_array().unwrap();
    // Seven figures of the paper, the convergence and the scan.
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

/// By keyboard: the first button has the focus, and arrow keys move to the next.
fn the_filter_works(browser: &mut Browser, counts: &[usize]) {
    let all: usize = counts.iter().sum();
    assert_eq!(count(&browser.evaluate(SHOWN)), all);
    browser.evaluate("document.getElementById('all').focus()");
    for &wanted in counts {
        browser.press("ArrowRight", 39);
        assert_eq!(count(&browser.evaluate(SHOWN)), wanted);
        let own = browser.evaluate(
            "new Set([...document.querySelectorAll('.claims .sortable tbody tr')].filter((row) => \
                row.getClientRects().length > 0).map((row) => row.className)).size",
        );
        assert_eq!(count(&own), usize::from(wanted > 0));
    }
    browser.press("ArrowRight", 39);
    assert_eq!(count(&browser.evaluate(SHOWN)), all);
}

fn columns_sort(browser: &mut Browser) {
    let order = "[...document.querySelectorAll('.claims .sortable tbody tr')].map((row) => \
        row.cells[3].dataset.key).join('')";
    let before = browser.evaluate(order);
    let click = "document.querySelectorAll('.claims .sortable thead button')[3].click()";
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

/// Links within the page have a target, and there are no others, so that the page can be moved
/// anywhere.
fn links_lead_somewhere(browser: &mut Browser, page: &Path) {
    let dangling = browser.evaluate(
        "[...document.querySelectorAll('a')].filter((a) => !a.hash || \
            !document.getElementById(a.hash.slice(1))).map((a) => a.href)",
    );
    assert_eq!(dangling, json!([]), "{}", page.display());
}
