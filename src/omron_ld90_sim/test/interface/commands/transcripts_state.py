"""Transcripts: the connection itself, status, infos and range devices.

Each transcript has command lines, then the immediate answer. A line in slashes is a regular
expression.
"""
from __future__ import annotations

IMMEDIATE = {
    'echo': [['echo', 'echo on', 'echo', 'echo off', 'echo sometimes'],
             ['Echo is off.', 'Echo turned on.', 'echo', 'Echo is on.', 'echo off',
              'Echo turned off.', 'usage: echo <on/off>']],
    'quit': [['quit'], ['Closing connection']],
    'arclSendText': [['arclSendText "Status: fooled you"'], ['Status: fooled you']],
    'connectOutgoing': [['connectOutgoing 127.0.0.1 7179', 'connectOutgoing here there'],
                        ['CommandError: connectOutgoing here there',
                         "CommandErrorDescription: Bad port 'there'"]],
    'shutDown': [['shutdown'], []],
    'status': [['status'], ['ExtendedStatusForHumans: Stopped', 'Status: Stopped',
                            'StateOfCharge: 100.0', 'Location: -3000 0 0',
                            r'/LocalizationScore: 0\.\d{6}/', 'Temperature: 36']],
    'oneLineStatus': [['onelinestatus'], ['Status: Stopped StateOfCharge: 100.0 '
                                          'Location: -3000 0 0 Temperature: 36']],
    'odometer': [['odometer'], ['Odometer: 0 mm 0 deg 0 sec']],
    'odometerReset': [['odometerReset'], ['Reset odometer']],
    'getDateTime': [['getDateTime'], [r'/DateTime: \d\d/\d\d/\d{4} \d\d:\d\d:\d\d/']],
    'createInfo': [['createinfo myString 10 testing', 'createInfo short 4 longer',
                    'createInfo Flags 3 500', 'getInfo short'],
                   ['Created info for myString', 'Created info for short',
                    'CommandError: createInfo Flags 3 500',
                    "CommandErrorDescription: Info 'Flags' is the robot's own",
                    'Info: short long']],
    'getInfoList': [['createInfo myString 10 testing', 'getinfolist'], [
        'Created info for myString', 'InfoList: WirelessLink', 'InfoList: WirelessQuality',
        'InfoList: Odometer(KM)', 'InfoList: HourMeter', 'InfoList: Temperature(C)',
        'InfoList: LaserScore', 'InfoList: LaserLock', 'InfoList: LaserNumSamples',
        'InfoList: LaserNumPeaks', 'InfoList: MPacs', 'InfoList: Laser_1 Pacs', 'InfoList: Flags',
        'InfoList: SBC Uptime', 'InfoList: ARAM Uptime', 'InfoList: Queue ID',
        'InfoList: Queue Job ID', 'InfoList: DebugLogState', 'InfoList: DebugLogSeconds',
        'InfoList: myString', 'End of info list']],
    'getInfo': [['getinfo Flags', 'getInfo SBC Uptime', 'getInfo Queue ID', 'getInfo LaserScore',
                 'getInfo b'],
                ['Info: Flags 400', 'Info: SBC Uptime 0', 'Info: Queue ID',
                 r'/Info: LaserScore 8\d/',
                 'CommandError: getInfo b', "CommandErrorDescription: No info 'b'"]],
    'updateInfo': [['createInfo myString 10 testing', 'updateinfo myString newtest',
                    'getInfo myString', 'updateInfo Flags 1'],
                   ['Created info for myString', 'Updated info for myString',
                    'Info: myString newtest', 'CommandError: updateInfo Flags 1',
                    "CommandErrorDescription: No info 'Flags'"]],
    'rangeDeviceGetCurrent': [['rangeDeviceGetCurrent laser_1', 'rangeDeviceGetCurrent Laser_7'],
                              [r'/RangeDeviceGetCurrent: Laser_1( -?\d+ -?\d+)+/',
                               'CommandError: rangeDeviceGetCurrent Laser_7',
                               "CommandErrorDescription: No range device 'Laser_7'"]],
    'rangeDeviceGetCumulative': [['rangeDeviceGetCumulative Laser_1'],
                                 [r'/RangeDeviceGetCumulative: Laser_1( -?\d+ -?\d+){1,200}/']],
    'rangeDeviceGetList': [['rangeDeviceGetList'], [
        'RangeDevice: Laser_1 LASER',
        'RangeDeviceCurrentDrawingData: Laser_1 polyDots 0x0000ff 0x000000 80 75 DefaultOn',
        'RangeDeviceCumulativeDrawingData: Laser_1 polyDots 0x0000ff 0x000000 80 75 DefaultOn',
        'EndOfRangeDeviceList']],
}
