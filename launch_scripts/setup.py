from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

here = Path(__file__).resolve().parent
manifest = ElementTree.parse(here / 'package.xml').getroot()
name = manifest.findtext('name')

# No setup.cfg here: these commands belong on PATH, not in lib/launch_scripts for `ros2 run`.
setup(
    name=name,
    version=manifest.findtext('version'),
    description=manifest.findtext('description'),
    license=manifest.findtext('license'),
    packages=find_packages(include=[name, f'{name}.*']),
    package_data={name: ['config/*', 'py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{name}']),
        (f'share/{name}', ['package.xml']),
    ],
    python_requires='>=3.10',
    zip_safe=False,
)
