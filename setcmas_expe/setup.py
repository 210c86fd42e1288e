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
    package_data={name: ['config/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{name}']),
        (f'share/{name}', ['package.xml']),
        (f'share/{name}/rviz', ['rviz/experiment_8.rviz']),
    ],
    python_requires='>=3.10',
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'bridges = setcmas_expe.safety.bridges:main',
            'cmd_vel_guard = setcmas_expe.safety.cmd_vel_guard:main',
            'doctor = setcmas_expe.doctor.main:main',
            'emulated_lab = setcmas_expe.emulation.lab:main',
            'inject_fault = setcmas_expe.emulation.inject_fault:main',
            'joystick_reader = setcmas_expe.pause.joystick_reader:main',
            'pause = setcmas_expe.pause.node:main',
        ],
    },
)
