from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

here = Path(__file__).resolve().parent
manifest = ElementTree.parse(here / 'package.xml').getroot()
name = manifest.findtext('name')

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
        (f'share/{name}/launch', [str(p.relative_to(here)) for p in here.glob('launch/*.py')]),
        (f'share/{name}/rviz', ['rviz/experiment_8.rviz']),
        (f'share/{name}/systemd', ['systemd/cmd_vel_guard@.service']),
    ],
    python_requires='>=3.10',
    zip_safe=False,
)
