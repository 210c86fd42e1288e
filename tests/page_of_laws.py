"""The page of `setcmas site` in Chromium, and a rubric and a law for it."""

from browser import wait_for
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

RUBRIC = """
title: My rubric
exercise: consensus
scenarios:
  - name: shown
    nb_robots: 3
    duration: 20
    criteria:
      - {name: meet, metric: disagreement, at_most: 0.1, points: 2}
      - {name: secret, metric: end_error, at_most: 0.1, points: 1, hidden: true}
  - name: secret too
    hidden: true
    nb_robots: 7
    criteria: [{name: meet, metric: disagreement, at_most: 0.1, points: 3}]
"""
LAW = """
K = 1.0

def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and t == 0:
        print('hello <b>bold</b>')
    x = -K * poses[0, robotNo - 1]
    y = -K * poses[1, robotNo - 1]
    return x, y
"""


class Page:
    """The page in Chromium."""

    def __init__(self, browser, address, downloads, asked):
        self.browser, self.asked = browser, asked
        self.address = f'{address}/index.html'
        self.downloads = downloads

    def open(self, fragment=''):
        self.browser.get('about:blank')
        self.browser.get(self.address + fragment)
        self.wait_until_begun()
        return self

    def wait_until_begun(self):
        wait_for(lambda: 'begun' in self.find('body').get_attribute('class'))

    def clean(self):
        """Open the page as somebody who was never here."""
        self.browser.get('about:blank')
        origin = {'origin': self.address.rpartition('/')[0], 'storageTypes': 'local_storage'}
        self.browser.execute_cdp_cmd('Storage.clearDataForOrigin', origin)
        return self.open()

    def script(self, code, *arguments):
        return self.browser.execute_script(code, *arguments)

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.find(selector).get_attribute('textContent')

    def click(self, selector):
        wait_for(self.find(selector).is_enabled)
        self.script('arguments[0].click()', self.find(selector))

    def write(self, text):
        """Replace the text of the editor, by its keyboard."""
        self.find('.cm-content').send_keys(Keys.CONTROL, 'a')
        self.script(
            """const data = new DataTransfer();
            data.setData('text/plain', arguments[0]);
            const pasted = {clipboardData: data, bubbles: true, cancelable: true};
            document.querySelector('.cm-content').dispatchEvent(
              new ClipboardEvent('paste', pasted));""",
            text,
        )

    def editor(self):
        return self.script(
            "return document.querySelector('.cm-content').cmTile.view.state.doc.toString()"
        )

    def set(self, name, value):
        field = self.find(f'#option-{name}')
        field.clear()
        field.send_keys(value)

    def wait(self):
        wait_for(lambda: not self.find('#do-stop').is_enabled())

    def run(self):
        self.click('#do-run')
        self.wait()

    def wait_for_download(self, name):
        wait_for((self.downloads / name).is_file)
        return self.downloads / name
