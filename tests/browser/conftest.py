"""A headless Chromium that keeps what pages complain about, and whatever they ask the network for."""

import shutil

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2, "is_mobile": True, "has_touch": True}
DESKTOP = {"viewport": {"width": 1280, "height": 900}}
DARK = DESKTOP | {"color_scheme": "dark"}
SCREENS = {"desktop": DESKTOP, "phone": PHONE, "dark": DARK}


@pytest.fixture(scope="module")
def browser():
    """The system's Chromium; tests are skipped without it or without playwright.

    Of one module, because playwright keeps an event loop running, which other tests may want to have for themselves.
    """
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is on the path")
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(params=list(SCREENS))
def screen(request):
    """Name of a screen: each test that uses `page` runs on all of them."""
    return request.param


@pytest.fixture
def page(browser, screen):
    """A page on one of the screens, with two lists: `complaints` (errors of console and scripts) and `requests`."""
    context = browser.new_context(**SCREENS[screen])
    page = context.new_page()
    page.complaints, page.requests = [], []
    page.on("console", lambda said: page.complaints.append(said.text) if said.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.on("request", lambda request: page.requests.append(request.url))
    yield page
    context.close()
